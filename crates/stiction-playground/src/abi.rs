//! Exported functions of the WebAssembly module, which exchange UTF-8 texts through the module's
//! memory.
//!
//! The page writes a request to the buffer that [`request`] returns, calls [`respond`], and reads
//! the answer from the buffer at [`response`]. Both buffers belong to the module, and remain valid
//! until the page calls the module again.
#![cfg_attr(target_arch = "wasm32", allow(unsafe_code, reason = "names of exported functions"))]

#[cfg(target_arch = "wasm32")]
mod exported {
    use crate::answer;
    use std::cell::RefCell;

    thread_local! {
        static REQUEST: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
        static RESPONSE: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    }

    #[link(wasm_import_module = "page")]
    unsafe extern "C" {
        /// Reports progress to the page: the number of steps done, and the total number of steps.
        safe fn progress(done: u32, of: u32);
    }

    /// Allocates the buffer of a request of `length` bytes; returns its address.
    #[unsafe(no_mangle)]
    extern "C" fn request(length: usize) -> *mut u8 {
        REQUEST.with_borrow_mut(|bytes| {
            bytes.clear();
            bytes.resize(length, 0);
            bytes.as_mut_ptr()
        })
    }

    /// Answers the request in the request buffer; returns the length of the answer in bytes.
    #[unsafe(no_mangle)]
    extern "C" fn respond() -> usize {
        let request = REQUEST.take();
        let text = answer(&String::from_utf8_lossy(&request), &mut |done, of| progress(done, of));
        let length = text.len();
        RESPONSE.replace(text.into_bytes());
        length
    }

    /// Returns the address of the buffer that contains the answer.
    #[unsafe(no_mangle)]
    extern "C" fn response() -> *const u8 {
        RESPONSE.with_borrow(Vec::as_ptr)
    }
}
