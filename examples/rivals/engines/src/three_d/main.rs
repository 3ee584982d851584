//! three-d's shadow maps and this library's masks in the same scenes, compared with the ray-traced
//! reference: see `README.md`.

mod context;
mod program;
mod sun;

use anyhow::{Result, ensure};
use rival_engines::{Rival, judge::JudgedScene, median};
use program::{INTENSITY, ThreeDProgram};
use std::{sync::Arc, time::Instant};
use sun::UmbrageSun;
use three_d::{DirectionalLight, Light, vec3};
use umbrage::{
    Cascades, Geometry, Layout, ShadowTechnique, View,
    techniques::{Exact, MapFilter as _, Pcf, ShadowMap},
};

/// Least fraction of equal pixels. The rest are edges, which two rasterisers place differently.
const SEEN_ALIKE: f64 = 0.99;
/// Sides of three-d's map, texels.
const SIZES: [u32; 3] = [1024, 2048, 4096];

/// Source of the sun's shadows.
pub enum ShadowSetting {
    /// three-d's own map with this number of texels on each side.
    ThreeD(u32),
    /// A technique of this library.
    Umbrage(Arc<dyn ShadowTechnique>),
}

/// A sun that casts shadows.
enum Sun {
    ThreeD(DirectionalLight, u32),
    Umbrage(UmbrageSun),
}

/// Changes from frame to frame.
#[derive(Clone, Copy, PartialEq)]
enum Moves {
    Camera,
    All,
}

fn main() -> Result<()> {
    rival_engines::run::<ThreeDProgram>()
}

impl Rival for ThreeDProgram {
    type Setting = ShadowSetting;

    const NAME: &'static str = "three_d";
    const COLUMNS: &'static [&'static str] =
        &["ms without", "ms more, all moves", "camera moves", "MiB"];
    /// Upper limit for surfaces that face away from the sun. three-d lights them by a thousandth of
    /// the light of surfaces that face it.
    const DARK: f32 = 1.1e-3;

    fn start(judged: &JudgedScene) -> Result<Self> {
        let program = Self::start(&judged.scene, &judged.geometry)?;
        program.frame(&program.sun());
        let alike = program.share_seen_alike(&judged.truth.receivers, &judged.scene.cameras[0]);
        eprintln!(
            "{}: {:.2} % of what is seen is seen alike; {}; the box of the casters has a diagonal of {:.0} m",
            judged.scene.name,
            100.0 * alike,
            program.renderer_name(),
            judged.geometry.caster_bounds().diagonal()
        );
        ensure!(
            alike >= SEEN_ALIKE,
            "three-d's image of `{}` differs from umbrage's view, so its shadows can't be compared",
            judged.scene.name
        );
        Ok(program)
    }

    fn lit_fractions(&mut self) -> Result<Vec<f32>> {
        self.picture(&self.sun())
    }

    fn settings(_: &JudgedScene) -> Vec<(String, ShadowSetting)> {
        settings()
    }

    fn measure(
        &mut self,
        judged: &JudgedScene,
        source: ShadowSetting,
        frames: usize,
    ) -> Result<(Vec<f32>, Vec<f64>)> {
        let without = self.sun();
        let mut sun = Sun::new(source, self, &judged.geometry, judged)?;
        let shadowed = self.picture(sun.light())?;
        let mut bare = Vec::new();
        let mut all_move = Vec::new();
        let mut camera_moves = Vec::new();
        for _ in 0..frames {
            let start = Instant::now();
            self.frame(&without);
            let bare_milliseconds = milliseconds_since(start);
            bare.push(bare_milliseconds);
            for (moves, more) in [
                (Moves::All, &mut all_move),
                (Moves::Camera, &mut camera_moves),
            ] {
                // Discard all derived data: a program with moving casters has new triangles.
                let fresh = (moves == Moves::All).then(|| judged.geometry.without_hierarchies());
                let geometry = fresh.as_ref().unwrap_or(&judged.geometry);
                let start = Instant::now();
                sun.update(moves, self, geometry, judged)?;
                self.frame(sun.light());
                more.push(milliseconds_since(start) - bare_milliseconds);
            }
        }
        let mebibytes = sun.bytes() as f64 / (1 << 20) as f64;
        let times = [bare, all_move, camera_moves].map(median);
        Ok((shadowed, [&times[..], &[mebibytes]].concat()))
    }
}

impl Sun {
    fn new(
        source: ShadowSetting,
        program: &ThreeDProgram,
        geometry: &Geometry,
        judged: &JudgedScene,
    ) -> Result<Self> {
        let mut sun = match source {
            ShadowSetting::ThreeD(size) => Self::ThreeD(program.sun(), size),
            ShadowSetting::Umbrage(technique) => {
                let color = vec3(INTENSITY, INTENSITY, INTENSITY);
                let size = judged.truth.size.to_array();
                Self::Umbrage(UmbrageSun::new(
                    program.context(),
                    technique,
                    color,
                    program.direction(),
                    size,
                ))
            }
        };
        sun.update(Moves::All, program, geometry, judged)?;
        Ok(sun)
    }

    /// Updates the shadows for a frame. A map of three-d's is the same for every camera.
    fn update(
        &mut self,
        moves: Moves,
        program: &ThreeDProgram,
        geometry: &Geometry,
        judged: &JudgedScene,
    ) -> Result<()> {
        match self {
            Self::ThreeD(light, size) => {
                if moves == Moves::All {
                    program.draw_map(light, *size)?;
                }
                Ok(())
            }
            Self::Umbrage(sun) => {
                let scene = &judged.scene;
                sun.update(&View::new(&scene.cameras[0], &scene.lights[0], geometry))
            }
        }
    }

    fn light(&self) -> &dyn Light {
        match self {
            Self::ThreeD(light, _) => light,
            Self::Umbrage(sun) => sun,
        }
    }

    /// Returns the bytes of maps and masks.
    fn bytes(&self) -> u64 {
        match self {
            Self::ThreeD(_, size) => 4 * u64::from(*size).pow(2),
            Self::Umbrage(sun) => sun.bytes(),
        }
    }
}

/// Returns the settings to run, with their names in the table.
fn settings() -> Vec<(String, ShadowSetting)> {
    let mut all = Vec::new();
    for size in SIZES {
        all.push((format!("three-d, {size}"), ShadowSetting::ThreeD(size)));
    }
    let one = |size| ShadowMap {
        size,
        ..ShadowMap::default()
    };
    let cascades = ShadowMap {
        layout: Layout::Cascades(Cascades::default()),
        ..one(2048)
    };
    let umbrage: [(&str, Arc<dyn ShadowTechnique>); 3] = [
        ("pcf 3x3, 2048", Arc::new(Pcf::new(1).on(one(2048)))),
        (
            "pcf 3x3, 4 cascades of 2048",
            Arc::new(Pcf::new(1).on(cascades)),
        ),
        ("exact", Arc::new(Exact::default())),
    ];
    for (label, technique) in umbrage {
        all.push((
            format!("umbrage, {label}"),
            ShadowSetting::Umbrage(technique),
        ));
    }
    all
}

fn milliseconds_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1000.0
}
