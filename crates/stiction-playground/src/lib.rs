//! Stiction in a browser: an engine that answers requests in JSON, and a page that sends these
//! requests.
//!
//! The function [`answer`] is the whole interface of the engine. In the WebAssembly module, `abi`
//! passes requests and answers through the memory of the module. The function [`page()`] returns
//! the page: gallery, editor, sliders, and the reports of the library.

mod abi;
mod answers;
mod page;
mod values;

pub use answers::answer;
pub use page::{ENGINE, Engine, page};
