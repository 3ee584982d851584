//! Writes what is told to a file, for tests on the desktop.

use super::widgets::Widgets;
use crate::app::App;
use anyhow::{Context as _, Result};
use serde_json::{Value, json};
use std::{fs, path::PathBuf};

/// A file that always holds what is told of the last frame.
pub(crate) struct ToldFile {
    path: PathBuf,
    written: String,
    /// For which question for truth masks were compared with the CPU's, and what came out.
    agreement: Option<(u64, Value)>,
}

impl ToldFile {
    pub(crate) fn new(path: PathBuf) -> Self {
        Self {
            path,
            written: String::new(),
            agreement: None,
        }
    }

    /// Writes what is told, if it is something else than before.
    ///
    /// # Errors
    /// Errors if the file can't be written.
    pub(crate) fn update(&mut self, app: &App, ctx: &egui::Context) -> Result<()> {
        let is_complete = app.figures.is_complete();
        let asked = app.figures.asked();
        if is_complete && self.agreement.as_ref().is_none_or(|(of, _)| *of != asked) {
            self.agreement = Some((asked, super::agreement(app)));
        }
        let told = json!({
            "report": super::report(app),
            "agreement": self.agreement.as_ref().filter(|_| is_complete).map(|(_, told)| told),
            "widgets": Widgets::told(ctx),
        });
        let text = told.to_string();
        if text == self.written {
            return Ok(());
        }
        // Readers never see half a file.
        let unfinished = self.path.with_extension("unfinished");
        let error = || format!("{} can't be written", self.path.display());
        fs::write(&unfinished, &text).with_context(error)?;
        fs::rename(&unfinished, &self.path).with_context(error)?;
        self.written = text;
        Ok(())
    }
}
