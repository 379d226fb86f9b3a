//! Plots, pictures of mechanisms, and the frame of pages: text in SVG and HTML, no files.

pub mod drawing;
pub mod figure;
pub mod numbers;
pub mod page;
pub mod xml;
