//! The HTML page of the playground.

use base64::prelude::{BASE64_STANDARD, Engine as _};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::{self, Write as _};
use stiction_draw::page::{application, source_of};
use stiction_draw::viewer::SCRIPT as VIEWER;

/// File name of the compiled WebAssembly module.
pub const ENGINE: &str = "stiction.wasm";

const STYLE: &str = include_str!("../page/style.css");
const BODY: &str = include_str!("../page/body.html");
const WORKER: &str = include_str!("../page/worker.js");
const SCRIPT: &str = concat!(
    "\n\"use strict\";\n(() => {\n",
    include_str!("../page/engine.js"),
    include_str!("../page/editor.js"),
    include_str!("../page/sliders.js"),
    include_str!("../page/link.js"),
    include_str!("../page/meshes.js"),
    include_str!("../page/main.js"),
    "})();\n"
);

/// Location of the compiled WebAssembly module.
#[derive(Clone, Copy, Debug)]
pub enum Engine<'a> {
    /// In the file [`ENGINE`] beside the page, on the same server.
    Beside,
    /// In the page itself, which can then be opened as a file.
    Inside(&'a [u8]),
}

/// Returns the complete HTML page. `shaded` is the script of the shaded view; empty if the module
/// has no shaded view.
///
/// The content security policy permits only the following code: the scripts of the page and of the
/// reports, identified by their digests; the worker, which the page creates from text in the page;
/// and the WebAssembly module.
///
/// # Errors
/// The WebAssembly module cannot be compressed.
pub fn page(engine: Engine<'_>, shaded: &str) -> io::Result<String> {
    let (module, connections) = match engine {
        Engine::Beside => (String::new(), "'self'"),
        Engine::Inside(bytes) => {
            let mut packed = GzEncoder::new(Vec::new(), Compression::best());
            packed.write_all(bytes)?;
            (BASE64_STANDARD.encode(packed.finish()?), "'none'")
        }
    };
    let shaded = if shaded.is_empty() { String::new() } else { source_of(shaded) };
    let policy = format!(
        "style-src 'unsafe-inline'; script-src {} {} {} blob: 'wasm-unsafe-eval'; worker-src blob:; \
         connect-src {connections}; img-src data: blob:",
        source_of(SCRIPT),
        source_of(VIEWER),
        shaded,
    );
    // Browsers do not execute scripts of the type `text/plain`; they contain data.
    let data = format!(
        "<script type=\"text/plain\" id=\"worker\">{WORKER}</script>\n\
         <script type=\"text/plain\" id=\"module\">{module}</script>\n"
    );
    let inner = format!("{BODY}{data}<script>{SCRIPT}</script>\n");
    Ok(application("Stiction playground", &policy, STYLE, &inner))
}
