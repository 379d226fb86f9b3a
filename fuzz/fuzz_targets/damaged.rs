#![no_main]

//! Models of the gallery with other numbers in them: bytes are choices, see `making`.

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let text = stiction_fuzz::making::damaged(bytes);
    stiction_fuzz::making::keep(&text);
    stiction_fuzz::trials::runs::mechanism(&text);
});
