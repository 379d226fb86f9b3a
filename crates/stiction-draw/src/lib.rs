//! Plots, pictures of mechanisms, and the frame of HTML pages. The results are SVG and HTML texts;
//! this crate writes no files.

pub mod drawing;
pub mod figure;
pub mod heat_map;
pub mod numbers;
pub mod page;
pub mod viewer;
pub mod xml;
