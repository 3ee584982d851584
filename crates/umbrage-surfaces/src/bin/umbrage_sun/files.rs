//! Output files. They are written next to their place and renamed, so that a killed run leaves
//! neither half a file nor a changed one.

use crate::{answer::FacetTable, picture};
use anyhow::{Context as _, Result, bail, ensure};
use gltf::binary::{Glb, Header};
use serde_json::json;
use std::{fmt::Write as _, fs, path::Path};
use umbrage_surfaces::{Facets, Up, glam::DVec3};

/// Format of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Csv,
    Npy,
    Glb,
    Png,
}

impl Format {
    pub(crate) fn of_path(path: &Path) -> Result<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        Ok(match extension.to_ascii_lowercase().as_str() {
            "csv" => Self::Csv,
            "npy" => Self::Npy,
            "glb" => Self::Glb,
            "png" => Self::Png,
            _ => bail!("`--out {}`: use .csv, .npy, .glb or .png", path.display()),
        })
    }
}

/// Writes the answer in the format of the path.
pub(crate) fn write(path: &Path, facets: &Facets, answer: &FacetTable) -> Result<()> {
    let bytes = match Format::of_path(path)? {
        Format::Csv => csv(facets, answer)?.into_bytes(),
        Format::Npy => {
            // The format has no comments: names and statements are a text next to it.
            let mut text = answer.report(facets).join("\n") + "\ncolumns:";
            for (name, _) in &answer.columns {
                write!(text, " {name}")?;
            }
            let mut note = path.as_os_str().to_owned();
            note.push(".txt");
            replace(Path::new(&note), (text + "\n").as_bytes())?;
            npy(answer)
        }
        Format::Glb => glb(facets, answer)?,
        Format::Png => picture::png(facets, answer)?,
    };
    replace(path, &bytes)
}

/// Replaces a file at once.
fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    let name = path.file_name().context("has no name")?.to_string_lossy();
    let part = path.with_file_name(format!(".{name}.part"));
    fs::write(&part, bytes)?;
    fs::rename(&part, path)?;
    Ok(())
}

/// Returns comments, a line of names, and a line for each facet: its centre, area and columns.
fn csv(facets: &Facets, answer: &FacetTable) -> Result<String> {
    let mut out = String::new();
    for line in answer.report(facets) {
        writeln!(out, "# {line}")?;
    }
    out += "facet,x_m,y_m,z_m,area_m2";
    for (name, _) in &answer.columns {
        write!(out, ",{name}")?;
    }
    out += if answer.spans.is_empty() {
        "\n"
    } else {
        ",spans\n"
    };
    for row in 0..facets.count() {
        let [a, b, c] = facets.corners_m(row);
        let centre = (a + b + c) / 3.0;
        let area = facets.area_m2(row);
        write!(out, "{row},{},{},{},{area}", centre.x, centre.y, centre.z)?;
        for (_, values) in &answer.columns {
            write!(out, ",{}", values[row])?;
        }
        if let Some(spans) = answer.spans.get(row) {
            write!(out, ",{spans}")?;
        }
        out.push('\n');
    }
    Ok(out)
}

/// Returns a matrix of 64-bit numbers, facets by columns, in NumPy's format 1.0.
fn npy(answer: &FacetTable) -> Vec<u8> {
    let rows = answer.shades().len();
    let shape = format!("({rows}, {})", answer.columns.len());
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    // The header fills a multiple of 64 bytes, after 10 bytes, and ends with a line feed.
    let length = (header.len() + 11).next_multiple_of(64) - 10;
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((length as u16).to_le_bytes());
    out.extend(format!("{header:<width$}\n", width = length - 1).bytes());
    for row in 0..rows {
        for (_, values) in &answer.columns {
            out.extend(values[row].to_le_bytes());
        }
    }
    out
}

/// Returns a glTF model with the facets' colours at their corners, and their numbers as
/// `_VALUE`.
fn glb(facets: &Facets, answer: &FacetTable) -> Result<Vec<u8>> {
    let up = facets.options().up;
    let y_up = |p: DVec3| match up {
        Up::Y => p,
        Up::Z => DVec3::new(p.x, p.z, -p.y),
    };
    let corners = || (0..facets.count()).flat_map(|row| facets.corners_m(row));
    let low = corners().fold(DVec3::INFINITY, |low, p| low.min(y_up(p)));
    let high = corners().fold(DVec3::NEG_INFINITY, |high, p| high.max(y_up(p)));
    // 32 bits hold positions near the middle; the node has the rest.
    let middle = low.midpoint(high);
    let count = 3 * facets.count();
    let mut positions = Vec::with_capacity(24 * count);
    for p in corners() {
        let near = (y_up(p) - middle).as_vec3();
        positions.extend(near.to_array().into_iter().flat_map(f32::to_le_bytes));
    }
    let [colors, values] = colors_and_values(answer);
    let [lengths, offsets] = [
        [positions.len(), colors.len(), values.len()],
        [0, positions.len(), positions.len() + colors.len()],
    ];
    let binary = [positions, colors, values].concat();
    let view = |i: usize| json!({"buffer": 0, "byteOffset": offsets[i], "byteLength": lengths[i]});
    let document = json!({
        "asset": {"version": "2.0", "generator": "umbrage-sun", "extras": {
            "about": answer.report(facets), "hash": format!("{:016x}", answer.stated.hash),
        }},
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": middle.to_array()}],
        "materials": [{"doubleSided": true, "extensions": {"KHR_materials_unlit": {}}}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "COLOR_0": 1, "_VALUE": 2}, "material": 0,
        }]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3",
             "min": (low - middle).as_vec3().to_array(), "max": (high - middle).as_vec3().to_array()},
            {"bufferView": 1, "componentType": 5121, "count": count, "type": "VEC4", "normalized": true},
            {"bufferView": 2, "componentType": 5126, "count": count, "type": "SCALAR"},
        ],
        "bufferViews": [view(0), view(1), view(2)],
        "buffers": [{"byteLength": binary.len()}],
    });
    let text = serde_json::to_vec(&document)?;
    let is_small = u32::try_from(text.len() + binary.len() + 64).is_ok();
    ensure!(is_small, "exceeds 4 GB; use .csv or .npy");
    // The length is computed when the file is written.
    let header = Header {
        magic: *b"glTF",
        version: 2,
        length: 0,
    };
    let file = Glb {
        header,
        json: text.into(),
        bin: Some(binary.into()),
    };
    Ok(file.to_vec()?)
}

/// Returns the colours (four bytes, linear) and the numbers (32 bits) of all facets' corners.
fn colors_and_values(answer: &FacetTable) -> [Vec<u8>; 2] {
    let scale = picture::Scale::of_answer(answer);
    let shades = answer.shades();
    let mut colors = Vec::with_capacity(12 * shades.len());
    let mut values = Vec::with_capacity(12 * shades.len());
    for &value in shades {
        // Colours at corners are linear.
        let linear = |encoded: u8| ((f64::from(encoded) / 255.0).powf(2.2) * 255.0).round() as u8;
        let [r, g, b] = scale.color(value).map(linear);
        for _ in 0..3 {
            colors.extend([r, g, b, 255]);
            values.extend((value as f32).to_le_bytes());
        }
    }
    [colors, values]
}
