//! The report of a comparison: a folder with a page, charts, tables, data and images.
//!
//! * `index.html`: recommendations, images, charts of time against error with their Pareto fronts,
//!   a table of all rows, and each scene's rows. It works from a file, and refers to the scenes'
//!   image files, so keep the folder together.
//! * `chart-time-<light>-<backend>.svg`, `chart-cost-...` and PNG: the charts over all scenes of
//!   hard and of soft shadows, for use elsewhere.
//! * `rows.csv`: one [`Line`] per row. `overall.csv`: one line per setting over all scenes.
//!   `work.csv`: the counted work and the time of each row. `results.json`: the [`Comparison`].
//! * `<scene>/truth.png`, `<scene>/<technique>.<backend>.png` and `.error.png`, with colours
//!   `.color.png`: images of the Pareto fronts, each technique's best row, and faults, and of one
//!   backend's rows on full-size scenes. Comparisons of up to three scenes have images of all
//!   rows, and `.lookups.png`: the number of lookups of each map texel. If a technique has several
//!   settings, the names contain them.
//! * `<scene>/truth.npy`, `t.npy` (distance along the unit camera ray), `ambiguous.npy`,
//!   `<technique>.<backend>.npy`, on request: NumPy arrays, float32, H x W, top row first, -1 where
//!   the camera hits nothing.
//! * `<scene>/scene.json`: the scene's figures, for a resumed run and for [`merge`]. Its first
//!   entry is a checksum of the rest, so that changed or truncated figures are rejected.
//! * `run.json`: the scenes of the folder's last run. Folders of other runs' scenes are ignored.
//!
//! Every file and every scene's folder is written completely under another name and then renamed.

mod arrays;
mod assemble;
mod chart;
mod chosen;
mod merge;
mod page;
mod page_rows;
mod run;
mod stability_source;
mod still;
mod store;
mod style;
mod table;
mod work_table;

pub use merge::merge;
pub(crate) use run::{MeasuredScene, measured_scenes};
pub use stability_source::StabilitySource;

pub use store::ComparisonPlan;
pub use table::{Line, lines, to_csv};

use crate::{
    compare::{Comparison, Environment, FEW_SCENES, RowImages, SceneImages, SceneResult},
    error::LabError,
    output::{folder::Folder, heat_map, png, program_hash},
};
use rayon::prelude::*;
use run::Run;
use std::path::{Path, PathBuf};
use store::Stored;
use umbrage_core::Invalid;

/// A report in progress: add scenes one by one, then finish it.
#[derive(Debug)]
pub struct Report {
    path: PathBuf,
    folder: Folder,
    run: Run,
    program: String,
    arrays: bool,
}

impl Report {
    /// Begins a report of these places of the plan in a folder. Creates the folder if needed, and
    /// overwrites files of an older report.
    ///
    /// # Errors
    /// Errors if the folder cannot be made or written.
    pub fn create(
        path: &Path,
        plan: ComparisonPlan,
        places: &[usize],
        arrays: bool,
    ) -> Result<Self, LabError> {
        let folder = Folder::create(path)?;
        let run = Run {
            plan,
            places: places.to_vec(),
        };
        // Write it first, so that a stopped run is not mistaken for the one before it.
        run.write(&folder)?;
        Ok(Self {
            path: path.to_owned(),
            folder,
            run,
            program: program_hash(),
            arrays,
        })
    }

    /// Reports whether the folder already has this place's scene. It must have been measured by
    /// this program, for the same plan, with the same backends and adapter, on the same kind of
    /// machine.
    ///
    /// # Errors
    /// Errors if the figures are truncated or changed: the scene must be measured again.
    pub fn has(&self, place: usize, environment: &Environment) -> Result<bool, Invalid> {
        let Some(name) = self.run.plan.scenes.get(place) else {
            return Ok(false);
        };
        let path = self.path.join(name);
        let has_arrays = !self.arrays || path.join("truth.npy").is_file();
        let Some(stored) = Stored::read(&path)? else {
            return Ok(false);
        };
        let is_same_program = !stored.program.is_empty() && stored.program == self.program;
        let is_same_machine = without_date(&stored.environment) == without_date(environment);
        let is_same_scene = stored.place == place && stored.plan == self.run.plan;
        Ok(has_arrays && is_same_program && is_same_machine && is_same_scene)
    }

    /// Writes a scene's figures, its images and, on request, its arrays.
    ///
    /// # Errors
    /// Errors if a file cannot be written.
    pub fn scene(
        &self,
        place: usize,
        environment: &Environment,
        notices: &[String],
        result: &SceneResult,
        images: &SceneImages,
    ) -> Result<(), LabError> {
        let Some(name) = self.run.plan.scenes.get(place) else {
            return Ok(());
        };
        let folder = self.folder.unfinished_folder(name)?;
        if self.arrays {
            arrays::write(&folder, result, images)?;
        }
        // Write the images of truth and of the selected rows.
        let truth = &images.truth;
        folder.write(
            "truth.png",
            &png::mask(truth.size, &truth.visibility, &truth.pixels)?,
        )?;
        let chosen = chosen::rows(result);
        let all = self.run.plan.scenes.len() <= FEW_SCENES;
        (0..result.rows.len())
            .into_par_iter()
            .filter(|i| all || chosen.contains(i) || images.rows[*i].color.is_some())
            .try_for_each(|i| row_pictures(&folder, result, images, i))?;
        if all {
            (0..result.rows.len())
                .into_par_iter()
                .try_for_each(|i| heat_picture(&folder, result, images, i))?;
        }
        // Write the figures last, and rename the folder.
        let stored = Stored {
            plan: self.run.plan.clone(),
            place,
            program: self.program.clone(),
            environment: environment.clone(),
            notices: notices.to_vec(),
            result: result.clone(),
        };
        stored.write(&folder)?;
        self.folder.finish(name)
    }

    /// Writes the page, the charts, the tables and the data. Returns the whole comparison and the
    /// page's path. `stability` has the verdicts that the page shows for each setting.
    ///
    /// # Errors
    /// Errors if a scene is missing, or a file cannot be written.
    pub fn finish(
        self,
        stability: Option<&StabilitySource>,
    ) -> Result<(Comparison, PathBuf), LabError> {
        let mut scenes = Vec::new();
        for &place in &self.run.places {
            scenes.push(self.read_stored(place)?);
        }
        assemble::write(&self.path, &self.folder, &scenes, stability)
    }

    /// Reads the figures of a place's scene.
    fn read_stored(&self, place: usize) -> Result<Stored, LabError> {
        let name = self.run.plan.scenes.get(place).map_or("", String::as_str);
        let path = self.path.join(name);
        Stored::read(&path)?.ok_or_else(|| LabError::Write {
            path: path.join(store::FILE),
            source: std::io::Error::other("the scene's figures are missing"),
        })
    }
}

/// Returns the environment without the date, to compare with that of stored figures.
fn without_date(environment: &Environment) -> Environment {
    Environment {
        date: None,
        ..environment.clone()
    }
}

/// Writes the images of a row, if it was measured.
fn row_pictures(
    folder: &Folder,
    result: &SceneResult,
    images: &SceneImages,
    row: usize,
) -> Result<(), LabError> {
    let truth = &images.truth;
    let RowImages { mask, color, .. } = &images.rows[row];
    let Some(mask) = mask else {
        return Ok(());
    };
    let stem = result.rows[row].stem();
    folder.write(
        &format!("{stem}.png"),
        &png::mask(truth.size, mask, &truth.pixels)?,
    )?;
    let error = png::error(truth.size, mask, &truth.visibility, &truth.pixels)?;
    folder.write(&format!("{stem}.error.png"), &error)?;
    if let Some(png) = color {
        folder.write(&format!("{stem}.color.png"), png)?;
    }
    Ok(())
}

/// Writes an image of the lookups in a row's maps, if it has any.
fn heat_picture(
    folder: &Folder,
    result: &SceneResult,
    images: &SceneImages,
    row: usize,
) -> Result<(), LabError> {
    let Some(heat) = &images.rows[row].lookups else {
        return Ok(());
    };
    folder.write(
        &format!("{}.lookups.png", result.rows[row].stem()),
        &heat_map(heat)?,
    )
}

#[cfg(test)]
mod page_tests;
#[cfg(test)]
mod tests;
