//! The report of a comparison: a folder with a page, a table, data and pictures.
//!
//! * `index.html`: self-contained, works from a file. Chart of time against error per scene with the Pareto fronts;
//!   mask, truth and error picture of every row.
//! * `rows.csv`: one [`Line`] a row. `results.json`: the [`Comparison`] as it is.
//! * `<scene>/truth.png`, `<scene>/<technique>.<backend>.png` and `.error.png`, with colours `.color.png`, of the rows that
//!   matter most: the Pareto fronts, each technique's best, and faults. On request NumPy arrays, float32, H x W, row 0 on top, -1 where the camera hits nothing: `<scene>/truth.npy`, `t.npy` (distance along the unit camera ray),
//!   `ambiguous.npy`, `<technique>.<backend>.npy`. Where a technique has several settings, they are part of the name.
//!
//! Every file is written whole under another name and then renamed.

mod arrays;
mod chart;
mod chosen;
mod files;
mod page;
pub(crate) mod pictures;
mod table;

pub use table::{Line, lines, to_csv};

use crate::{
    LabError,
    compare::{Comparison, Row, SceneImages, SceneResult, slug},
};
use files::Folder;
use page::{ImageStore, RowPictures, ScenePage};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// A report in the making. Give it scenes as they come, then finish it.
#[derive(Debug)]
pub struct Report {
    path: PathBuf,
    folder: Folder,
    arrays: bool,
    names: Vec<String>,
    images: ImageStore,
    pages: Vec<ScenePage>,
}

impl Report {
    /// Begins a report in a folder, which is made if need be; files of an older report are overwritten.
    ///
    /// # Errors
    /// When the folder cannot be made.
    pub fn create(path: &Path, arrays: bool) -> Result<Self, LabError> {
        let folder = Folder::create(path)?;
        let (names, images, pages) = (Vec::new(), ImageStore::default(), Vec::new());
        Ok(Self { path: path.to_owned(), folder, arrays, names, images, pages })
    }

    /// Writes a scene's pictures and, if asked for, its arrays.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn scene(&mut self, result: &SceneResult, images: &SceneImages) -> Result<(), LabError> {
        let name = self.unique_name(&result.name);
        let folder = self.folder.inner(&name)?;
        if self.arrays {
            arrays::write(&folder, result, images)?;
        }
        let truth = &images.truth;
        let truth_png = picture(pictures::mask(truth.size, &truth.visibility, &truth.pixels))?;
        folder.write("truth.png", &truth_png)?;
        let truth_id = self.images.add(&truth_png);
        let pictured = chosen::rows(result);
        let encoded: Vec<_> = (0..result.rows.len())
            .into_par_iter()
            .map(|i| if pictured.contains(&i) || images.colors[i].is_some() { encode(images, i) } else { Ok(None) })
            .collect::<Result<_, _>>()?;
        let mut rows = Vec::new();
        for (row, encoded) in result.rows.iter().zip(encoded) {
            rows.push(encoded.map(|encoded| self.row_pictures(&folder, row, &encoded)).transpose()?);
        }
        let (front, traces) = chart::of(result);
        self.pages.push(ScenePage { index: self.pages.len(), truth: truth_id, rows, front, traces });
        Ok(())
    }

    /// Writes a row's pictures and remembers them for the page.
    fn row_pictures(&mut self, folder: &Folder, row: &Row, encoded: &Encoded) -> Result<RowPictures, LabError> {
        let stem = format!("{}.{}", row.slug, row.backend);
        let mut put = |what: &str, png: &[u8]| -> Result<usize, LabError> {
            folder.write(&format!("{stem}{what}.png"), png)?;
            Ok(self.images.add(png))
        };
        let (mask, error) = (put("", &encoded.mask)?, put(".error", &encoded.error)?);
        let color = encoded.color.as_ref().map(|png| put(".color", png)).transpose()?;
        Ok(RowPictures { mask, error, color })
    }

    /// Writes the page, the table and the data. Returns the page's path.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn finish(self, comparison: &Comparison) -> Result<PathBuf, LabError> {
        let broken = |what: &str, e: &dyn std::fmt::Display| LabError::Write {
            path: self.path.join(what),
            source: std::io::Error::other(e.to_string()),
        };
        let csv = to_csv(&lines(comparison)).map_err(|e| broken("rows.csv", &e))?;
        let json = serde_json::to_vec_pretty(comparison).map_err(|e| broken("results.json", &e))?;
        let page = page::html(comparison, &self.pages, &self.images).map_err(|e| broken("index.html", &e))?;
        self.folder.write("rows.csv", &csv)?;
        self.folder.write("results.json", &json)?;
        self.folder.write("index.html", page.as_bytes())?;
        Ok(self.path.join("index.html"))
    }

    /// A folder name that no other scene of this report has.
    fn unique_name(&mut self, scene: &str) -> String {
        let stem = slug(scene);
        let taken = |name: &str| self.names.iter().any(|n| n == name);
        let numbered = (2..).map(|n| format!("{stem}-{n}"));
        let name = std::iter::once(stem.clone()).chain(numbered).find(|n| !taken(n)).unwrap_or(stem);
        self.names.push(name.clone());
        name
    }
}

/// A row's pictures, PNG.
struct Encoded {
    mask: Vec<u8>,
    error: Vec<u8>,
    color: Option<Vec<u8>>,
}

/// The pictures of a row, if it was measured.
fn encode(images: &SceneImages, row: usize) -> Result<Option<Encoded>, LabError> {
    let (truth, Some(mask)) = (&images.truth, &images.masks[row]) else { return Ok(None) };
    Ok(Some(Encoded {
        mask: picture(pictures::mask(truth.size, mask, &truth.pixels))?,
        error: picture(pictures::error(truth.size, mask, &truth.visibility, &truth.pixels))?,
        color: images.colors[row].clone(),
    }))
}

pub(crate) fn picture(encoded: image::ImageResult<Vec<u8>>) -> Result<Vec<u8>, LabError> {
    encoded.map_err(|e| LabError::Write { path: "picture".into(), source: std::io::Error::other(e) })
}

#[cfg(test)]
mod tests;
