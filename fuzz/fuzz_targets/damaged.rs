#![no_main]

//! Gallery models with some numbers replaced; the fuzzer's bytes select the replacements, see
//! `making`.

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let text = stiction_fuzz::making::damaged(bytes);
    stiction_fuzz::making::keep(&text);
    stiction_fuzz::trials::runs::mechanism(&text);
});
