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
    /// What came of comparing the present masks with the CPU's.
    agreement: Option<Value>,
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
        // A mask that is made anew is not there for a frame or more.
        if !app.figures.is_complete() {
            self.agreement = None;
        } else if self.agreement.is_none() {
            self.agreement = Some(super::agreement(app));
        }
        let told = json!({
            "report": super::report(app),
            "agreement": self.agreement,
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
