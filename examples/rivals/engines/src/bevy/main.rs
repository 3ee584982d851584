//! Bevy's own shadows and this library's in the same Bevy scenes, compared with the ray-traced
//! reference: see `README.md`.

mod app;
mod plugin;

use anyhow::Result;
use app::{BevyProgram, BevyShadows, ShadowSource};
use rival_engines::{Rival, judge::JudgedScene, median};
use bevy::light::ShadowFilteringMethod as Filter;
use std::sync::Arc;
use umbrage::{
    Cascades, Fit, Layout, ShadowTechnique,
    techniques::{Exact, MapFilter as _, Pcf, Pcss, ShadowMap},
};

fn main() -> Result<()> {
    rival_engines::run::<BevyProgram>()
}

impl Rival for BevyProgram {
    type Setting = ShadowSource;

    const NAME: &'static str = "bevy";
    const COLUMNS: &'static [&'static str] = &["ms", "ms without shadows", "MiB"];
    const DARK: f32 = 1e-4;

    fn start(judged: &JudgedScene) -> Result<Self> {
        Self::start(&judged.scene, &judged.geometry, &ShadowSource::Nothing)
    }

    fn lit_fractions(&mut self) -> Result<Vec<f32>> {
        self.picture()
    }

    fn settings(judged: &JudgedScene) -> Vec<(String, ShadowSource)> {
        let distances = judged.truth.receivers.distance.iter().copied();
        let farthest = distances.fold(0.0, f32::max);
        let is_soft = !judged.scene.lights[0].is_ideal();
        let mut all = vec![(
            "none, but a prepass".to_owned(),
            ShadowSource::NothingButPrepass,
        )];
        for (label, settings) in bevy_settings(farthest, is_soft) {
            all.push((format!("Bevy, {label}"), ShadowSource::Bevy(settings)));
        }
        for (label, technique) in umbrage_settings(farthest, is_soft) {
            let redrawn = ShadowSource::Umbrage(Arc::clone(&technique), true);
            all.push((format!("umbrage, {label}"), redrawn));
            let kept = ShadowSource::Umbrage(technique, false);
            all.push((format!("umbrage, {label}, nothing moves"), kept));
        }
        all
    }

    fn measure(
        &mut self,
        judged: &JudgedScene,
        source: ShadowSource,
        frames: usize,
    ) -> Result<(Vec<f32>, Vec<f64>)> {
        let mut program = Self::start(&judged.scene, &judged.geometry, &source)?;
        let shadowed = program.picture()?;
        let mut with_shadows = Vec::new();
        let mut without_shadows = Vec::new();
        for _ in 0..frames {
            without_shadows.push(self.frame()?);
            with_shadows.push(program.frame()?);
        }
        let mebibytes = program.bytes() as f64 / (1 << 20) as f64;
        let figures = vec![median(with_shadows), median(without_shadows), mebibytes];
        Ok((shadowed, figures))
    }
}

/// Returns Bevy's default, and settings that might improve it in a view with this `farthest`
/// distance, metres.
fn bevy_settings(farthest: f32, is_soft: bool) -> Vec<(String, BevyShadows)> {
    let default = BevyShadows {
        size: 2048,
        cascades: 4,
        far: 150.0,
        filter: Filter::Gaussian,
        soft: None,
        contact: false,
    };
    let reaching = BevyShadows {
        far: farthest,
        ..default
    };
    let mut all = vec![
        ("default".to_owned(), default),
        ("as far as is seen".to_owned(), reaching),
    ];
    if is_soft {
        // Bevy's setting is in a unit of neither length nor angle, so test several values.
        for soft in [3.0, 10.0, 30.0] {
            let settings = BevyShadows {
                soft: Some(soft),
                ..reaching
            };
            all.push((format!("as far as is seen, soft {soft}"), settings));
        }
        return all;
    }
    let two_by_two = BevyShadows {
        filter: Filter::Hardware2x2,
        ..reaching
    };
    let temporal = BevyShadows {
        filter: Filter::Temporal,
        ..reaching
    };
    let small = BevyShadows {
        size: 1024,
        ..reaching
    };
    let contact = BevyShadows {
        contact: true,
        ..reaching
    };
    all.push(("as far as is seen, hardware 2x2".to_owned(), two_by_two));
    all.push(("as far as is seen, temporal".to_owned(), temporal));
    all.push(("as far as is seen, 1024".to_owned(), small));
    all.push(("as far as is seen, contact shadows".to_owned(), contact));
    all
}

/// Returns the library's settings: cascades like Bevy's, which don't shimmer while the camera
/// moves, tightly fitted cascades, and `exact`.
fn umbrage_settings(farthest: f32, is_soft: bool) -> Vec<(&'static str, Arc<dyn ShadowTechnique>)> {
    let tight = ShadowMap {
        size: 2048,
        layout: Layout::Cascades(Cascades::default()),
        ..ShadowMap::default()
    };
    let stable = ShadowMap {
        fit: Fit::Stable { range: farthest },
        ..tight
    };
    if is_soft {
        let pcss = |map| -> Arc<dyn ShadowTechnique> { Arc::new(Pcss::default().on(map)) };
        return vec![
            ("pcss, 4 stable cascades of 2048", pcss(stable)),
            ("pcss, 4 cascades of 2048", pcss(tight)),
        ];
    }
    let pcf = |map| -> Arc<dyn ShadowTechnique> { Arc::new(Pcf::new(1).on(map)) };
    let small = ShadowMap {
        size: 1024,
        ..tight
    };
    vec![
        ("pcf 3x3, 4 stable cascades of 2048", pcf(stable)),
        ("pcf 3x3, 4 cascades of 2048", pcf(tight)),
        ("pcf 3x3, 4 cascades of 1024", pcf(small)),
        ("exact", Arc::new(Exact::default())),
    ]
}
