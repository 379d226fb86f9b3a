#![no_main]

//! Generated mechanisms; the fuzzer's bytes select their parts, see `making`.

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let text = stiction_fuzz::making::mechanism(bytes);
    stiction_fuzz::making::keep(&text);
    stiction_fuzz::trials::runs::mechanism(&text);
});
