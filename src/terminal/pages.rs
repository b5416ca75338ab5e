//! Where reports and films go.
use super::failure::Failure;
use super::output;
use bipedc_analysis::report::{Film, Report, write, write_film, write_strobe, write_svg};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::Ledger;
use clap::Args;
use std::path::PathBuf;

/// Where a report goes.
#[derive(Args)]
pub struct Pages {
    /// Write a page to look at: the robot, plots, causes; opens in any browser, needs no network
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Write the page's pictures into this folder, for papers
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
}

impl Pages {
    /// Neither page nor pictures.
    pub const NONE: Self = Self { report: None, svg: None };

    /// Whether anything is to be written.
    pub fn wanted(&self) -> bool {
        self.report.is_some() || self.svg.is_some()
    }

    /// Notes page and pictures among what is written.
    ///
    /// # Errors
    /// They would overwrite an input or another output.
    pub fn note(&self, ledger: &mut Ledger) -> Result<(), Diagnostic> {
        if let Some(page) = &self.report {
            ledger.writes("--report", page)?;
        }
        self.svg.as_ref().map_or(Ok(()), |folder| ledger.fills("--svg", folder, "svg"))
    }

    /// Writes page and pictures; says so on the error stream.
    ///
    /// # Errors
    /// What the file system refuses.
    pub fn write(&self, report: &Report) -> Result<(), Failure> {
        if let Some(page) = &self.report {
            write(report, page)?;
            output::remark(&format!("wrote {}", page.display()));
        }
        if let Some(folder) = &self.svg {
            let pictures = write_svg(report, folder)?;
            output::remark(&format!("wrote {} pictures into {}", pictures.len(), folder.display()));
        }
        Ok(())
    }

    /// The same of a simulated motion.
    ///
    /// # Errors
    /// What the file system refuses.
    pub fn write_film(&self, film: &Film) -> Result<(), Failure> {
        if let Some(page) = &self.report {
            write_film(film, page)?;
            output::remark(&format!("wrote {}", page.display()));
        }
        if let Some(folder) = &self.svg {
            let pictures = write_strobe(film, folder)?;
            output::remark(&format!("wrote {} pictures into {}", pictures.len(), folder.display()));
        }
        Ok(())
    }
}
