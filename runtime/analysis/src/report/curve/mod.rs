//! A few curves over one axis, as a picture and as a page.
mod page;
mod picture;

pub use page::render_curves;
pub use picture::curves_svg;

use super::data::Fact;
use super::map::Table;

/// Curves in one frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CurveFigure {
    /// Of picture and page.
    pub title: String,
    /// Name of the robot.
    pub robot: String,
    /// Label of the horizontal axis, with its unit.
    pub x: String,
    /// Label of the vertical axis, with its unit.
    pub y: String,
    /// Whether the axes count something.
    pub counted: [bool; 2],
    /// The vertical axis begins at zero.
    pub from_zero: bool,
    /// Those that are said last lie on top.
    pub curves: Vec<Curve>,
    /// What the page says of them.
    pub facts: Vec<Fact>,
    /// Below the picture.
    pub table: Table,
}

/// A curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// How it looks.
    pub kind: CurveKind,
    /// For the legend; empty: none.
    pub words: String,
    /// What is no finite number is a gap.
    pub points: Vec<[f64; 2]>,
}

/// How a curve looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurveKind {
    /// A line with a dot at each point.
    Main,
    /// Dots alone.
    Dots,
    /// A second line.
    Other,
    /// A third line.
    Third,
    /// What is reached at most.
    Limit,
    /// What is wished.
    Wish,
}

impl CurveKind {
    /// Of style sheets.
    fn class(self) -> &'static str {
        match self {
            Self::Main | Self::Dots => "held-out",
            Self::Other => "training",
            Self::Third => "after",
            Self::Limit => "before",
            Self::Wish => "floor",
        }
    }
}
