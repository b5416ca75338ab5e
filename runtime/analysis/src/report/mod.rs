//! The report: one self-contained HTML page to look at, and the same pictures as SVG files for papers.
//!
//! A command fills a [`Report`]; [`write()`] and [`write_svg`] do the rest. The page needs no network: plots are drawn
//! by uPlot (`assets/vendor/uplot`, MIT), everything else is HTML and SVG made here. Every text is escaped, numbers
//! that are not finite become gaps.
//!
//! ```
//! use bipedc_analysis::experiments::Channel;
//! use bipedc_analysis::report::{Report, Row, Series, render};
//!
//! let time: Vec<f64> = (0..100).map(|i| 0.01 * f64::from(i)).collect();
//! let measured: Vec<f64> = time.iter().map(|t| (6.0 * t).sin()).collect();
//! let nominal = measured.iter().map(|u| 0.9 * u).collect();
//! let series = Series { time, measured, nominal, ..Series::default() };
//! let row = Row::new("knee", Channel::Effort, "N m", 0.01, series).at_joint("knee");
//! assert!((row.unexplained_before - 0.1).abs() < 0.01);
//! let page = render(&Report { title: "A knee".to_owned(), rows: vec![row], ..Report::default() });
//! assert!(page.starts_with("<!DOCTYPE html>"));
//! ```
mod causes;
mod curve;
mod data;
mod fill;
mod film;
mod map;
mod opening;
mod page;
mod payload;
mod sections;
mod svg;
mod thin;
mod write;

pub use crate::experiments::plotted::{Row, RowPart, Series, Signal};
pub use curve::{Curve as PlottedCurve, CurveFigure, CurveKind, curves_svg, render_curves};
pub use data::{
    Abscissa, Bone, ChangeLine, Drawing, DrawnJoint, Estimated, Fact, HistoryStep, Hull, NextStep, Report,
};
pub use fill::rows_of;
pub use film::{
    Balance, Curve, Film, FilmFoot, FilmPart, FilmPoint, Form, Frame, Picture, Plot, Pose, render_film,
    write_film, write_strobe,
};
pub use map::{MapAxisFigure, MapFigure, MapPanel, Table, map_svg, render_map};
pub use page::render;
pub use write::{write, write_svg};

/// The page stays below this many bytes: rows are thinned out until they fit.
pub const LARGEST_PAGE: usize = 5_000_000;
