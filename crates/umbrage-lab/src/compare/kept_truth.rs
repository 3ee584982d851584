//! Truth stored between runs: tracing it takes longer than rendering a scene's rows.
//!
//! A file's name is a hash of everything that truth depends on: triangles, camera, light, options,
//! and the program. It begins with a checksum of the rest, so that truncated or changed files are
//! traced again.

use super::seen::SceneView;
use crate::{
    error::LabError,
    output::{checksum, folder::Folder, program_hash},
};
use std::{
    fs,
    path::PathBuf,
    time::{Duration, SystemTime},
};
use umbrage_core::{Receivers, metrics::Pixel};
use umbrage_plan::truth::{Truth, TruthOptions};

/// Maximum total size, bytes. The least recently used files are removed.
const MAX_BYTES: u64 = 1 << 30;

/// A folder with stored truth.
#[derive(Clone, Debug)]
pub struct KeptTruth {
    folder: PathBuf,
    /// Hash of the program. Truth of another program is not used.
    program: String,
}

impl KeptTruth {
    /// Stores truth in a folder, which is created with the first file.
    pub fn in_folder(folder: PathBuf) -> Self {
        Self {
            folder,
            program: program_hash(),
        }
    }

    fn name(&self, view: &SceneView<'_>, options: &TruthOptions) -> String {
        let triangles = view.geometry.fingerprint();
        let camera = view.camera;
        let light = view.light;
        let program = &self.program;
        let text = format!("{triangles:x} {camera:?} {light:?} {options:?} {program}");
        format!("{}.truth", checksum(text.as_bytes()))
    }

    /// Returns the stored truth for the `receivers` of the camera. `None` if there is none, or it
    /// is damaged.
    pub(super) fn read(
        &self,
        view: &SceneView<'_>,
        options: &TruthOptions,
        receivers: Receivers,
    ) -> Option<Truth> {
        // Without the program's hash, the origin of truth is unknown.
        if self.program.is_empty() {
            return None;
        }
        let path = self.folder.join(self.name(view, options));
        let bytes = fs::read(&path).ok()?;
        let truth = decode_truth(&bytes, receivers, view.geometry.fingerprint())?;
        // Mark the file as recently used. If this fails it is removed earlier, which only costs
        // time.
        if let Ok(file) = fs::File::options().append(true).open(&path) {
            let _ = file.set_modified(SystemTime::now());
        }
        Some(truth)
    }

    /// Stores truth. Removes the least recently used files if the total size is too large.
    ///
    /// # Errors
    /// Errors if the folder can't be written.
    pub(super) fn write(
        &self,
        view: &SceneView<'_>,
        options: &TruthOptions,
        truth: &Truth,
    ) -> Result<(), LabError> {
        // Nothing would be read then: see `read`.
        if self.program.is_empty() {
            return Ok(());
        }
        let folder = Folder::create(&self.folder)?;
        folder.write(&self.name(view, options), &encode_truth(truth))?;
        for name in self.too_many() {
            folder.remove(&name)?;
        }
        Ok(())
    }

    /// Returns the names of the least recently used files beyond [`MAX_BYTES`].
    fn too_many(&self) -> Vec<String> {
        let mut files = Vec::new();
        for entry in fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if let Ok(data) = entry.metadata()
                && name.ends_with(".truth")
            {
                let used = data.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                files.push((used, data.len(), name));
            }
        }
        files.sort_unstable_by(|a, b| b.cmp(a));
        let mut bytes = 0;
        let mut out = Vec::new();
        for (_, length, name) in files {
            bytes += length;
            if bytes > MAX_BYTES {
                out.push(name);
            }
        }
        out
    }
}

/// Classes of pixels, by their code in files.
const CLASSES: [Pixel; 6] = [
    Pixel::Counted,
    Pixel::Empty,
    Pixel::Unlit,
    Pixel::Ambiguous,
    Pixel::Elsewhere,
    Pixel::Unsampled,
];

/// Returns a file's bytes.
///
/// They are the checksum of the rest, the tracing time in seconds, the contact distance, and then
/// for each pixel its visibility, error, distance to the blocker, class and ambiguity. All numbers
/// are little-endian.
fn encode_truth(truth: &Truth) -> Vec<u8> {
    let mut rest = Vec::new();
    rest.extend(truth.elapsed.as_secs_f64().to_le_bytes());
    rest.extend(truth.contact.to_le_bytes());
    for i in 0..truth.pixels.len() {
        rest.extend(truth.visibility[i].to_le_bytes());
        rest.extend(truth.error[i].to_le_bytes());
        rest.extend(truth.blocker[i].to_le_bytes());
        let class = CLASSES.iter().position(|class| *class == truth.pixels[i]);
        rest.push(class.map_or(u8::MAX, |class| class as u8));
        rest.push(u8::from(truth.ambiguous[i]));
    }
    let mut out = checksum(&rest).into_bytes();
    out.extend(rest);
    out
}

/// Bytes per pixel.
const PIXEL_BYTES: usize = 14;
/// Bytes of a checksum.
const CHECKSUM_BYTES: usize = 16;

/// Returns the truth in a file. `None` if it is damaged or of another size.
fn decode_truth(bytes: &[u8], receivers: Receivers, fingerprint: u64) -> Option<Truth> {
    let (expected, rest) = bytes.split_at_checked(CHECKSUM_BYTES)?;
    if checksum(rest).as_bytes() != expected {
        return None;
    }
    let (seconds, rest) = rest.split_first_chunk()?;
    let (contact, rest) = rest.split_first_chunk()?;
    let count = receivers.len();
    if rest.len() != count * PIXEL_BYTES {
        return None;
    }
    let mut truth = Truth {
        size: receivers.size,
        visibility: Vec::with_capacity(count),
        error: Vec::with_capacity(count),
        pixels: Vec::with_capacity(count),
        ambiguous: Vec::with_capacity(count),
        blocker: Vec::with_capacity(count),
        contact: f32::from_le_bytes(*contact),
        receivers,
        fingerprint,
        elapsed: Duration::try_from_secs_f64(f64::from_le_bytes(*seconds)).ok()?,
    };
    for pixel in rest.chunks_exact(PIXEL_BYTES) {
        let (visibility, pixel) = pixel.split_first_chunk()?;
        let (error, pixel) = pixel.split_first_chunk()?;
        let (blocker, pixel) = pixel.split_first_chunk()?;
        truth.visibility.push(f32::from_le_bytes(*visibility));
        truth.error.push(f32::from_le_bytes(*error));
        truth.blocker.push(f32::from_le_bytes(*blocker));
        truth.pixels.push(*CLASSES.get(usize::from(pixel[0]))?);
        truth.ambiguous.push(pixel[1] != 0);
    }
    Some(truth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;
    use umbrage_core::{Camera, Geometry, Light};
    use umbrage_cpu::Cpu;

    struct TruthFixture {
        camera: Camera,
        light: Light,
        geometry: Geometry,
        options: TruthOptions,
    }

    impl TruthFixture {
        fn new() -> Self {
            let scene = umbrage_scenes::by_argument("teapot-lamp").expect("built in");
            Self {
                camera: scene.cameras[0].with_size(UVec2::new(24, 18)),
                light: scene.lights[0],
                geometry: Geometry::bake(&scene).expect("valid"),
                options: TruthOptions {
                    samples: 8,
                    probe_samples: 4,
                    block_side: 2,
                    ..TruthOptions::default()
                },
            }
        }

        fn view(&self) -> SceneView<'_> {
            SceneView {
                camera: &self.camera,
                light: &self.light,
                geometry: &self.geometry,
            }
        }

        fn read(&self, kept: &KeptTruth, receivers: Receivers) -> Option<Truth> {
            kept.read(&self.view(), &self.options, receivers)
        }

        fn receivers(&self) -> Receivers {
            Cpu::new()
                .receivers(&self.camera, &self.geometry)
                .expect("valid")
        }

        fn truth(&self) -> Truth {
            let find =
                &mut |camera: &Camera, geometry: &Geometry| Cpu::new().receivers(camera, geometry);
            let Self {
                camera,
                light,
                geometry,
                options,
            } = self;
            umbrage_plan::truth::trace(camera, light, geometry, options, find, &|_, _| {})
                .expect("valid")
        }
    }

    fn bits(values: &[f32]) -> Vec<u32> {
        values.iter().map(|value| value.to_bits()).collect()
    }

    #[test]
    fn what_is_kept_is_what_was_traced() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let kept = KeptTruth::in_folder(dir.path().join("truth"));
        let stage = TruthFixture::new();
        assert!(stage.read(&kept, stage.receivers()).is_none());
        let truth = stage.truth();
        kept.write(&stage.view(), &stage.options, &truth)
            .expect("writable");
        let read = stage.read(&kept, stage.receivers()).expect("kept");
        assert_eq!(bits(&read.visibility), bits(&truth.visibility));
        assert_eq!(bits(&read.error), bits(&truth.error));
        assert_eq!(bits(&read.blocker), bits(&truth.blocker));
        assert_eq!(
            (read.pixels, read.ambiguous),
            (truth.pixels, truth.ambiguous)
        );
        assert_eq!((read.contact, read.size), (truth.contact, truth.size));
        // There is no stored truth for another camera, light, option or program.
        let mut other = TruthFixture::new();
        other.options.samples = 9;
        assert!(other.read(&kept, stage.receivers()).is_none());
        let mut other = TruthFixture::new();
        other.camera = other.camera.nudged_by(glam::Vec2::X);
        assert!(other.read(&kept, stage.receivers()).is_none());
        let rebuilt = KeptTruth {
            program: "another".to_owned(),
            ..kept.clone()
        };
        assert!(stage.read(&rebuilt, stage.receivers()).is_none());
    }

    #[test]
    fn what_was_changed_or_cut_off_is_not_taken_up() {
        let stage = TruthFixture::new();
        let bytes = encode_truth(&stage.truth());
        let read = |bytes: &[u8]| decode_truth(bytes, stage.receivers(), 0).is_some();
        assert!(read(&bytes));
        for place in [0, 20, bytes.len() - 1] {
            let mut changed = bytes.clone();
            changed[place] ^= 1;
            assert!(!read(&changed), "byte {place}");
        }
        for length in [0, 10, CHECKSUM_BYTES, bytes.len() - 1] {
            assert!(!read(&bytes[..length]), "{length} bytes");
        }
    }
}
