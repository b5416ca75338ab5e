//! Maps of a gait as pictures and as a page: a raster of speeds, lines and marks over it.
mod contour;
mod data;
mod page;
mod picture;
mod raster;

pub use data::{MapAxisFigure, MapFigure, MapPanel, Table};
pub use page::render_map;
pub(in crate::report) use page::table;
pub use picture::map_svg;
