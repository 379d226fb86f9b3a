//! Plots, pictures of mechanisms, and the frame of HTML pages, as SVG and HTML text without files.

pub mod drawing;
pub mod figure;
pub mod heat_map;
pub mod numbers;
pub mod page;
pub mod viewer;
pub mod xml;
