//! NumPy files: float32, H x W, top row first, -1 where the camera hits nothing.
//!
//! The format is version 1.0 of NumPy Enhancement Proposal 1, "A Simple File Format for NumPy
//! Arrays" (<https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>).

use crate::output::folder::Folder;
use crate::{
    compare::{SceneImages, SceneResult},
    error::LabError,
};
use glam::UVec2;
use std::io;
use umbrage_core::{NO_TRIANGLE, Receivers};

/// First bytes of every NumPy file.
const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// Major and minor version of the format.
const VERSION: [u8; 2] = [1, 0];
/// Number of bytes before the header's text: magic, version, and the text's length as 16 bits.
const PREFIX_BYTES: usize = MAGIC.len() + VERSION.len() + 2;
/// Alignment of the data, bytes.
const ALIGNMENT: usize = 64;

/// Writes truth, distance along the unit camera ray, ambiguity, and one visibility array per
/// measured row.
pub(super) fn write(
    folder: &Folder,
    result: &SceneResult,
    images: &SceneImages,
) -> Result<(), LabError> {
    let truth = &images.truth;
    let receivers = &truth.receivers;
    let ambiguous: Vec<f32> = truth
        .ambiguous
        .iter()
        .map(|is_ambiguous| f32::from(u8::from(*is_ambiguous)))
        .collect();
    write_array(folder, "truth.npy", receivers, &truth.visibility)?;
    write_array(folder, "t.npy", receivers, &receivers.distance)?;
    write_array(folder, "ambiguous.npy", receivers, &ambiguous)?;
    for (row, images) in result.rows.iter().zip(&images.rows) {
        if let Some(mask) = &images.mask {
            let name = format!("{}.{}.npy", row.slug, row.backend);
            write_array(folder, &name, receivers, mask)?;
        }
    }
    Ok(())
}

/// Writes an array of the receivers' size, with -1 where the camera hits nothing.
fn write_array(
    folder: &Folder,
    name: &str,
    receivers: &Receivers,
    values: &[f32],
) -> Result<(), LabError> {
    let mut array = values.to_vec();
    for (value, &triangle) in array.iter_mut().zip(&receivers.triangle) {
        if triangle == NO_TRIANGLE {
            *value = -1.0;
        }
    }
    let bytes = npy(receivers.size, &array).map_err(|e| LabError::write(name, e))?;
    folder.write(name, &bytes)
}

/// Returns a two-dimensional array of little-endian float32 in NumPy's format. `values` are
/// `size.y` rows of `size.x`, row by row.
///
/// # Errors
/// Errors if the number of values is not that of `size`.
pub(super) fn npy(size: UVec2, values: &[f32]) -> io::Result<Vec<u8>> {
    let expected = u64::from(size.x) * u64::from(size.y);
    if values.len() as u64 != expected {
        let found = values.len();
        return Err(io::Error::other(format!(
            "an array of {expected} values cannot have {found}"
        )));
    }
    let header = header(size);
    let header_bytes = u16::try_from(header.len()).map_err(io::Error::other)?;
    let mut bytes = Vec::with_capacity(PREFIX_BYTES + header.len() + size_of_val(values));
    bytes.extend(MAGIC);
    bytes.extend(VERSION);
    bytes.extend(header_bytes.to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    Ok(bytes)
}

/// Returns the header's text: a Python dictionary literal, padded with blanks up to the final line
/// break.
fn header(size: UVec2) -> String {
    let rows = size.y;
    let columns = size.x;
    let dictionary =
        format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    let unpadded_bytes = PREFIX_BYTES + dictionary.len() + 1;
    let padding = unpadded_bytes.next_multiple_of(ALIGNMENT) - unpadded_bytes;
    format!("{dictionary}{}\n", " ".repeat(padding))
}

/// Parses a file that [`npy`] wrote, by the rules of the format. Returns rows, columns and values.
#[cfg(test)]
pub(super) fn read_npy(bytes: &[u8]) -> (usize, usize, Vec<f32>) {
    assert_eq!(&bytes[..6], b"\x93NUMPY");
    assert_eq!(bytes[6..8], [1, 0], "version 1.0");
    let header_bytes = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let (head, data) = bytes.split_at(10 + header_bytes);
    assert_eq!(head.len() % 64, 0, "the data are aligned");
    let header = std::str::from_utf8(&head[10..]).expect("text");
    let dictionary = header
        .strip_suffix('\n')
        .expect("one line")
        .trim_end_matches(' ');
    let shape = dictionary
        .strip_prefix("{'descr': '<f4', 'fortran_order': False, 'shape': (")
        .and_then(|rest| rest.strip_suffix("), }"))
        .expect("the three keys, in order of the alphabet");
    let (rows, columns) = shape.split_once(", ").expect("two dimensions");
    let rows: usize = rows.parse().expect("a number");
    let columns: usize = columns.parse().expect("a number");
    let (floats, rest) = data.as_chunks::<4>();
    assert!(rest.is_empty());
    assert_eq!(floats.len(), rows * columns);
    let values = floats.iter().map(|float| f32::from_le_bytes(*float));
    (rows, columns, values.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_come_back_with_rows_first() {
        let values: Vec<f32> = (0..6).map(|i| i as f32 - 2.5).collect();
        let bytes = npy(UVec2::new(3, 2), &values).expect("as many as places");
        assert_eq!(read_npy(&bytes), (2, 3, values));
    }

    /// The padding is right for any number of digits of the shape.
    #[test]
    fn headers_fill_up_to_the_alignment() {
        for width in [1, 10, 100, 1000, 10_000, 100_000] {
            let header = header(UVec2::new(width, 7));
            assert_eq!((PREFIX_BYTES + header.len()) % ALIGNMENT, 0, "{width}");
        }
    }

    #[test]
    fn a_wrong_count_is_refused() {
        assert!(npy(UVec2::new(3, 2), &[0.0; 5]).is_err());
    }
}
