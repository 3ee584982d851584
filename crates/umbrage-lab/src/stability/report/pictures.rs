//! Image files of the cells, next to the page.

use crate::{
    error::LabError,
    output::{folder::Folder, slug},
    stability::cell::Stability,
};

/// Folder of the images, next to the page.
pub(super) const FOLDER: &str = "pictures";

/// Image file of each cell of each case, relative to the page; `None` without an image.
pub(super) type PictureNames = Vec<Vec<Option<String>>>;

/// Returns the names of all images: the case's, the technique's and the settings', each file once.
pub(super) fn names(stability: &Stability) -> PictureNames {
    let mut taken: Vec<String> = Vec::new();
    let mut out = Vec::new();
    for case in &stability.cases {
        let mut of_case = Vec::new();
        for cell in &case.cells {
            if cell.picture.is_none() {
                of_case.push(None);
                continue;
            }
            let words = format!("{} {}", cell.technique, case.settings_without_fit(cell));
            let stem = format!("{}.{}", slug(&case.case), slug(&words));
            let mut name = format!("{stem}.png");
            let mut number = 2;
            while taken.contains(&name) {
                name = format!("{stem}-{number}.png");
                number += 1;
            }
            taken.push(name.clone());
            of_case.push(Some(format!("{FOLDER}/{name}")));
        }
        out.push(of_case);
    }
    out
}

/// Writes all images under their names, and removes those of an older run.
pub(super) fn write(
    folder: &Folder,
    stability: &Stability,
    names: &PictureNames,
) -> Result<(), LabError> {
    let unfinished = folder.unfinished_folder(FOLDER)?;
    for (case, names) in stability.cases.iter().zip(names) {
        for (cell, name) in case.cells.iter().zip(names) {
            let name = name.as_ref().and_then(|name| name.strip_prefix(FOLDER));
            if let (Some(png), Some(name)) = (&cell.picture, name) {
                unfinished.write(name.trim_start_matches('/'), png)?;
            }
        }
    }
    folder.finish(FOLDER)
}
