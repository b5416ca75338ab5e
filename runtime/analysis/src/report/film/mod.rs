//! The film of a simulated motion: a page to play it, and a stroboscopic picture of it for papers.
//!
//! A simulation fills a [`Film`] (`bipedc::film` does); [`write_film`] and [`write_strobe`] do the rest. Nothing of
//! the page comes from a network.
mod data;
mod page;
mod payload;
mod strobe;

pub use data::{Balance, Curve, Film, FilmFoot, FilmPart, FilmPoint, Form, Frame, Picture, Plot, Pose};
pub use page::render as render_film;

use super::svg::standalone;
use super::write::Pictures;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::write_with_folders;
use std::path::{Path, PathBuf};

/// Writes the page. Missing folders are made; nobody ever sees half a file.
///
/// # Errors
/// What the file system refuses.
pub fn write_film(film: &Film, path: &Path) -> Result<(), Diagnostic> {
    write_with_folders(path, &render_film(film))
}

/// Writes stroboscopic pictures into a folder: `side.svg` and `front.svg`. Says which files it wrote: none of a film
/// without frames.
///
/// # Errors
/// What the file system refuses.
pub fn write_strobe(film: &Film, folder: &Path) -> Result<Vec<PathBuf>, Diagnostic> {
    let mut pictures = Pictures::into(folder);
    for view in [strobe::View::Side, strobe::View::Front] {
        if let Some((picture, size)) = strobe::picture(film, view) {
            pictures.put(view.name(), &standalone(&film.title, size, &picture))?;
        }
    }
    pictures.commit()
}
