//! NumPy files: float32, H x W, row 0 on top, -1 where the camera hits nothing.

use crate::output::Folder;
use crate::{
    LabError,
    compare::{SceneImages, SceneResult},
};
use glam::UVec2;
use npyz::WriterBuilder;
use std::io;
use umbrage_core::{NO_TRIANGLE, Receivers};

/// Writes truth, distance along the unit camera ray, ambiguity, and one visibility array a measured row.
pub(super) fn write(
    folder: &Folder,
    result: &SceneResult,
    images: &SceneImages,
) -> Result<(), LabError> {
    let truth = &images.truth;
    let put = |name: &str, values: &dyn Fn(usize) -> f32| -> Result<(), LabError> {
        let bytes = npy(truth.size, &masked(&truth.receivers, values))
            .map_err(|e| LabError::write(name, e))?;
        folder.write(name, &bytes)
    };
    put("truth.npy", &|i| truth.visibility[i])?;
    put("t.npy", &|i| truth.receivers.distance[i])?;
    put("ambiguous.npy", &|i| {
        f32::from(u8::from(truth.ambiguous[i]))
    })?;
    for (row, mask) in result.rows.iter().zip(&images.masks) {
        if let Some(mask) = mask {
            put(&format!("{}.{}.npy", row.slug, row.backend), &|i| mask[i])?;
        }
    }
    Ok(())
}

fn masked(receivers: &Receivers, value: &dyn Fn(usize) -> f32) -> Vec<f32> {
    receivers
        .triangle
        .iter()
        .enumerate()
        .map(|(i, &t)| if t == NO_TRIANGLE { -1.0 } else { value(i) })
        .collect()
}

/// A two-dimensional array in NumPy's format.
pub(super) fn npy(size: UVec2, values: &[f32]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let shape = [u64::from(size.y), u64::from(size.x)];
    let mut writer = npyz::WriteOptions::new()
        .default_dtype()
        .shape(&shape)
        .writer(&mut bytes)
        .begin_nd()?;
    writer.extend(values.iter().copied())?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_come_back_with_rows_first() {
        let values: Vec<f32> = (0..6).map(|i| i as f32).collect();
        let bytes = npy(UVec2::new(3, 2), &values).expect("memory");
        let file = npyz::NpyFile::new(&bytes[..]).expect("valid");
        assert_eq!((file.shape(), file.order()), (&[2, 3][..], npyz::Order::C));
        assert_eq!(file.into_vec::<f32>().expect("floats"), values);
        assert_eq!(&bytes[..6], b"\x93NUMPY");
    }

    #[test]
    fn a_wrong_count_is_refused() {
        assert!(npy(UVec2::new(3, 2), &[0.0; 5]).is_err());
    }
}
