//! Stiction in a browser: the engine answers requests in JSON, and a page around it sends them.
//!
//! [`answer`] is the whole interface. In the WebAssembly module, `abi` passes its texts through the
//! module's memory. [`page()`] is the page: gallery, editor, sliders, and the reports of the
//! library.

mod abi;
mod answers;
mod page;
mod values;

pub use answers::answer;
pub use page::{ENGINE, Engine, page};
