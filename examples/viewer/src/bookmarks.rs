//! Failures of shadow methods: the scenes of the catalogue of failures, still or in motion. Each
//! has settings with the artefact and settings that fix it.
//!
//! Rows whose artefact no settings of a side produce are excluded. [`of_still`] lists them with the
//! reasons.

use crate::side::{FitKind, SideSettings, entry};
use umbrage::{
    Light,
    scenes::{
        self, Failure, Kind, SceneEntry,
        motion::{Motion, MovingScene},
    },
    techniques::{
        Bias, Hard, MapFilter as _, Pcf, Pcss, SecondDepth, ShadowMap, TechniquePreset, Vsm,
    },
};

/// Side of the maps with artefacts, texels: coarse enough for artefacts to be obvious.
pub(crate) const COARSE: u32 = 512;
/// Side of the map of `sealed-room`, texels: its walls are then an eighth of a texel thick.
const COARSER_THAN_WALLS: u32 = 128;
/// Number of maps of a sun that follow the camera.
const CASCADES: u32 = 3;
/// A bias of a fiftieth of the depth range, which makes gaps obvious.
const TOO_MUCH: Bias = Bias {
    constant: 0.02,
    ..Bias::NONE
};
/// A bias that is too small for distant receivers of a long plane.
const TOO_LITTLE: Bias = Bias {
    constant: 0.0003,
    ..Bias::NONE
};
/// Radius of a filter of 7x7, texels.
const WIDE: u32 = 3;
/// Range of the map of `tower-out-of-view`, metres. It excludes a part of the tower's shadow.
const TOO_NEAR: f32 = 6.0;

/// Kinds of artefacts, in the order of lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum FaultKind {
    /// Surfaces shadow themselves.
    Acne,
    /// Shadows are detached from their casters.
    PeterPanning,
    /// Light leaks through or around its casters.
    LightLeaking,
    /// Maps of moments leak light into the shadow of two casters.
    LightBleeding,
    /// A kernel crosses the corner of a wall.
    CornerLines,
    /// A shadow is missing, or ends too early.
    MissingShadow,
    /// Texels are larger than pixels or casters.
    Aliasing,
    /// Edges change while the camera or the light moves.
    Shimmering,
    /// A penumbra is too wide or too narrow.
    PenumbraWidth,
}

impl FaultKind {
    /// Returns the usual name.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Acne => "shadow acne",
            Self::PeterPanning => "peter-panning",
            Self::LightLeaking => "light leaking",
            Self::LightBleeding => "light bleeding",
            Self::CornerLines => "lines along corners",
            Self::MissingShadow => "missing shadow",
            Self::Aliasing => "aliasing",
            Self::Shimmering => "shimmering",
            Self::PenumbraWidth => "wrong penumbra width",
        }
    }

    /// Returns other names.
    pub(crate) const fn other_names(self) -> &'static str {
        match self {
            Self::Acne => "surface acne, self-shadowing, stripes, moire",
            Self::PeterPanning => "detached shadows, floating objects, gap at the contact",
            Self::LightLeaking => "light leaks, holes in shadows",
            Self::LightBleeding => "light leaks of variance maps, halos",
            Self::CornerLines => "dark lines, bright lines, seams at creases",
            Self::MissingShadow => "lost shadow, shadow cut off, popping",
            Self::Aliasing => "jagged edges, jaggies, stairs, blocky or pixelated shadows",
            Self::Shimmering => "crawling, swimming or flickering edges",
            Self::PenumbraWidth => "shadows too soft or too hard, one width for all penumbrae",
        }
    }
}

/// A failure of shadow methods.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bookmark {
    /// Row of the catalogue of failures.
    pub row: u8,
    pub name: &'static str,
    pub summary: &'static str,
    /// The built-in scene.
    pub scene: &'static str,
    /// The artefact on the left.
    pub kind: FaultKind,
    fails: Fails,
}

/// Failures at rest or in motion.
#[derive(Clone, Copy, Debug)]
enum Fails {
    Still(Failure),
    InMotion(MovingScene),
}

/// Settings with the artefact of a still scene.
struct StillFault {
    kind: FaultKind,
    preset: TechniquePreset,
    /// Range of the map around the camera, metres. `None` for a tight fit.
    reach: Option<f32>,
}

/// Returns all failures, sorted by the kind of artefact, then by row.
pub(crate) fn all() -> Vec<Bookmark> {
    let still = scenes::all().iter().filter_map(of_entry);
    // The renderer does not move casters.
    let moving = MovingScene::ALL
        .into_iter()
        .filter(|moving| moving.motion != Motion::Casters);
    let mut out: Vec<_> = still.chain(moving.map(of_moving)).collect();
    out.sort_by_key(|bookmark| (bookmark.kind, bookmark.row));
    out
}

/// Returns the failure of this name, if there is one.
pub(crate) fn find(name: &str) -> Option<Bookmark> {
    all().into_iter().find(|bookmark| bookmark.name == name)
}

fn of_entry(entry: &'static SceneEntry) -> Option<Bookmark> {
    let Kind::Failure(failure) = entry.kind else {
        return None;
    };
    let fault = of_still(entry.name, failure)?;
    Some(Bookmark {
        row: failure.row(),
        name: entry.name,
        summary: entry.summary,
        scene: entry.name,
        kind: fault.kind,
        fails: Fails::Still(failure),
    })
}

fn of_moving(moving: MovingScene) -> Bookmark {
    Bookmark {
        row: moving.row,
        name: moving.name,
        summary: moving.motion.label(),
        scene: moving.scene,
        kind: FaultKind::Shimmering,
        fails: Fails::InMotion(moving),
    }
}

impl Bookmark {
    /// Returns the label in lists: the artefact and the name.
    pub(crate) fn label(&self) -> String {
        format!("{}: {}", self.kind.name(), self.name)
    }

    /// Returns a longer description.
    pub(crate) fn description(&self) -> String {
        let others = self.kind.other_names();
        format!("{}; row {}. Also called: {others}", self.summary, self.row)
    }

    /// Returns the motion, if there is one.
    pub(crate) const fn moving_scene(&self) -> Option<MovingScene> {
        match self.fails {
            Fails::Still(_) => None,
            Fails::InMotion(moving) => Some(moving),
        }
    }

    /// Returns settings with the artefact. `range` is the camera's range of view, metres.
    pub(crate) fn fault(&self, range: f32) -> SideSettings {
        match self.fails {
            Fails::Still(failure) => match of_still(self.name, failure) {
                Some(fault) => fault.side(range),
                // `of_entry` excludes such scenes.
                None => without_map(None, range),
            },
            Fails::InMotion(moving) => moving_map(FitKind::Tight, &moving),
        }
    }

    /// Returns settings without artefacts for a light. `range` is the camera's range of view,
    /// metres.
    pub(crate) fn fix(&self, light: Option<&Light>, range: f32) -> SideSettings {
        match self.fails {
            // Maps of a turning sun change with every fit.
            Fails::InMotion(moving) if !moving.motion.moves_shadows() => {
                moving_map(FitKind::Stable, &moving)
            }
            Fails::Still(_) | Fails::InMotion(_) => without_map(light, range),
        }
    }
}

/// Returns hard shadows from maps that follow the camera.
fn moving_map(fit: FitKind, moving: &MovingScene) -> SideSettings {
    let mut out = SideSettings::new(entry("hard"), moving.range);
    if let Some(own) = out.preset.map().copied() {
        out.preset = out.preset.with_map(ShadowMap {
            size: COARSE,
            ..own
        });
    }
    SideSettings {
        fit,
        cascades: CASCADES,
        ..out
    }
}

impl StillFault {
    /// Returns the settings as a side. `range` is the camera's range of view, metres.
    fn side(self, range: f32) -> SideSettings {
        let mut out = SideSettings::new(entry(self.preset.technique().name()), range);
        out.preset = self.preset;
        if let Some(reach) = self.reach {
            out.fit = FitKind::AroundCamera;
            out.range = reach;
        }
        out
    }
}

/// Returns the settings with the artefact of a scene. `None` if no settings of a side have that
/// artefact.
fn of_still(scene: &str, failure: Failure) -> Option<StillFault> {
    let map = |bias| ShadowMap {
        size: COARSE,
        bias,
        ..ShadowMap::default()
    };
    let hard = |bias| TechniquePreset::from(Hard {}.on(map(bias)));
    let wide = |bias| TechniquePreset::from(Pcf::new(WIDE).on(map(bias)));
    let second_depth = || TechniquePreset::from(SecondDepth::default().on(map(Bias::FRONT_CULL)));
    let pcss = || TechniquePreset::from(Pcss::default().on(map(Bias::ADAPTIVE)));
    let (kind, preset) = match failure {
        // The normal offset of one comparison, with a kernel of radius 3.
        Failure::LowSun if scene == "low-sun-10" => (FaultKind::Acne, wide(Bias::NORMAL_OFFSET)),
        Failure::LowSun | Failure::Relief | Failure::TwoLights => {
            (FaultKind::Acne, hard(Bias::NONE))
        }
        Failure::DistantReceivers => (FaultKind::Acne, hard(TOO_LITTLE)),
        // Enough for most facets, too little for those that light grazes.
        Failure::LowPoly => (FaultKind::Acne, hard(Bias::CONSTANT)),
        // More than the distance of the slices.
        Failure::ThinContact | Failure::ThinSlices => (FaultKind::PeterPanning, hard(TOO_MUCH)),
        // Casters move away by two texels of their slope, which is more than the thickness of a
        // wall.
        Failure::SealedRoom => {
            let map = ShadowMap {
                size: COARSER_THAN_WALLS,
                ..map(Bias::POLYGON_OFFSET)
            };
            (FaultKind::LightLeaking, Hard {}.on(map).into())
        }
        // Casters that are not closed have no second surface.
        Failure::BrokenMesh => (FaultKind::LightLeaking, second_depth()),
        Failure::OpenShell => (FaultKind::MissingShadow, second_depth()),
        // Like the variance maps of textbooks, without reduction of bleeding.
        Failure::NearContact | Failure::LightBleeding => {
            let vsm = Vsm {
                bleeding_reduction: 0.0,
                ..Vsm::default()
            }
            .on(map(Bias::ADAPTIVE));
            (FaultKind::LightBleeding, vsm.into())
        }
        Failure::RoomCorner => (FaultKind::CornerLines, wide(Bias::ADAPTIVE)),
        // The clip depth of a perspective light is dense near it: the constant exceeds the bar's
        // distance.
        Failure::CasterAtLight => (FaultKind::MissingShadow, hard(Bias::CONSTANT)),
        Failure::CasterOutOfView => (FaultKind::MissingShadow, hard(Bias::ADAPTIVE)),
        Failure::FineDetail | Failure::CutOut | Failure::Landscape | Failure::IntoLight => {
            (FaultKind::Aliasing, hard(Bias::ADAPTIVE))
        }
        // Penumbrae of constant width.
        Failure::RisingHeights => (FaultKind::PenumbraWidth, wide(Bias::ADAPTIVE)),
        // One width for each position, from the mean of its blockers.
        Failure::TwoBlockers | Failure::Canopy | Failure::SmallLight => {
            (FaultKind::PenumbraWidth, pcss())
        }
        // Artefacts of `volumes` and `planar`, which light sets refuse.
        Failure::EyeInUmbra | Failure::ManyVolumes | Failure::Stairs => return None,
        // Artefacts that no technique here has: the faces of cubes overlap, fits contain the rim of
        // a cone, any axis and any projection, and no bias is in metres. Maps of 16 bits are equal
        // to others under all biases without acne.
        Failure::CubeSeams
        | Failure::ConeRim
        | Failure::LightAlongUp
        | Failure::OtherProjection
        | Failure::Scale
        | Failure::LongRange
        | Failure::Nothing => return None,
        // The reference has the same imprecise positions. The artefact is only visible in motion,
        // as in `hills-1e6-pan`.
        Failure::FarFromOrigin => return None,
    };
    let reach = (failure == Failure::CasterOutOfView).then_some(TOO_NEAR);
    Some(StillFault {
        kind,
        preset,
        reach,
    })
}

fn without_map(light: Option<&Light>, range: f32) -> SideSettings {
    let is_ideal = light.is_none_or(Light::is_ideal);
    let name = if is_ideal { "exact" } else { "soft" };
    SideSettings::new(entry(name), range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{collections::HashSet, fs, path::Path};
    use umbrage::{
        Backend as _, Camera, CastMode, Geometry, Source, View,
        cpu::Cpu,
        glam::UVec2,
        metrics::Errors,
        plan::truth::{Truth, TruthOptions, trace},
    };

    /// Size of the images, pixels.
    const SIZE: UVec2 = UVec2::new(320, 180);
    /// Least fraction of wrong pixels for an artefact, percent. In a window of 1280x720 that is
    /// 4,600 pixels: a patch of 68x68, or a line 4 pixels wide across the image.
    const LEAST_WRONG: f64 = 0.5;
    /// Least ratio of an artefact's wrong pixels, in its direction, to those due to the map's
    /// coarse texels.
    const BEYOND_TEXELS: f64 = 2.0;
    /// Least ratio for moments, relative to a filter of the same width, which blurs equally.
    const BEYOND_BLUR: f64 = 1.0;
    /// Greatest ratio of a fix's error to that of the artefact. Area lights leave some noise.
    const MOST_LEFT: f64 = 0.5;
    /// Rays for each pixel. Their noise is far below any artefact.
    const TRUTH: TruthOptions = TruthOptions {
        samples: 256,
        penumbra_factor: 1,
        probe_samples: 64,
        ambiguous_change: 0.125,
        block_side: 1,
    };

    #[test]
    fn cures_of_scenes_with_holes_know_holes() {
        let mut with_holes = 0;
        for bookmark in all() {
            let entry = scenes::find(bookmark.scene).expect(bookmark.scene);
            let scene = (entry.build)();
            let geometry = Geometry::bake(&scene).expect("built in");
            if geometry.has_cut_out_casters() {
                let cure = bookmark.fix(scene.lights.first(), 1.0);
                let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
                let recipe = cure.technique(&scene.lights[0]).recipe(&view);
                assert!(recipe.is_ok(), "{}: {recipe:?}", bookmark.name);
                with_holes += 1;
            }
        }
        assert!(with_holes > 0, "no bookmark has holes");
    }

    #[test]
    fn each_place_has_names_of_its_own_and_a_scene() {
        let all = all();
        assert!(all.len() > 40, "{}", all.len());
        let labels: HashSet<String> = all.iter().map(Bookmark::label).collect();
        assert_eq!(labels.len(), all.len());
        for bookmark in all {
            assert!(scenes::find(bookmark.scene).is_some(), "{}", bookmark.scene);
            assert_eq!(
                find(bookmark.name).map(|found| found.row),
                Some(bookmark.row)
            );
        }
        assert!(find("eye-in-umbra").is_none(), "light sets refuse volumes");
    }

    /// A still failure, rendered as in the viewer, with its reference.
    struct Rendered {
        camera: Camera,
        light: Light,
        geometry: Geometry,
        truth: Truth,
        range: f32,
    }

    impl Rendered {
        fn new(scene: &str) -> Self {
            let entry = scenes::find(scene).expect(scene);
            let scene = (entry.build)();
            let geometry = Geometry::bake(&scene).expect("built in");
            let camera = scene.cameras[0].with_size(SIZE);
            let light = scene.lights[0];
            let mut cpu = Cpu::new();
            let see = &mut |c: &Camera, g: &Geometry| cpu.receivers(c, g);
            let truth = trace(&camera, &light, &geometry, &TRUTH, see, &|_, _| {});
            Self {
                truth: truth.expect("built in"),
                range: 0.5 * geometry.bounds().diagonal(),
                camera,
                light,
                geometry,
            }
        }

        /// Returns the errors of a side. Fits have no receivers, as in the window.
        fn errors(&self, side: &SideSettings) -> Errors {
            let view = View::new(&self.camera, &self.light, &self.geometry);
            let technique = side.technique(&self.light);
            let recipe = technique.recipe(&view).expect("valid");
            for cast in &recipe.casts {
                let is_of_light = matches!(cast.source, Source::Casters | Source::SomeCasters(_));
                let keeps_depth = !matches!(cast.mode, CastMode::StencilDepthFail { .. });
                assert!(
                    is_of_light && keeps_depth,
                    "light sets refuse {}",
                    side.label()
                );
            }
            let seen = view.with_receivers(&self.truth.receivers);
            let mask = Cpu::new().render(&seen, &recipe).expect("rendered").mask;
            let Truth {
                visibility, pixels, ..
            } = &self.truth;
            Errors::measure(SIZE, &mask, visibility, pixels).expect("of that size")
        }
    }

    /// Returns the fraction of pixels that are wrong in the direction of the artefact, percent.
    /// `None` if the artefact has no direction.
    const fn in_its_way(kind: FaultKind, errors: &Errors) -> Option<f64> {
        match kind {
            FaultKind::Acne => Some(errors.false_shadow),
            FaultKind::PeterPanning
            | FaultKind::LightLeaking
            | FaultKind::LightBleeding
            | FaultKind::MissingShadow => Some(errors.false_light),
            FaultKind::CornerLines
            | FaultKind::Aliasing
            | FaultKind::Shimmering
            | FaultKind::PenumbraWidth => None,
        }
    }

    /// Each still scene shows its artefact: many pixels are wrong in the artefact's direction, and
    /// not only due to the map's coarse texels or a filter's blur. The fix has a far smaller error.
    /// The module `path` tests artefacts in motion.
    #[test]
    fn cures_are_right_where_faults_are_wrong() {
        let mut failed = Vec::new();
        for bookmark in all() {
            if bookmark.moving_scene().is_some() {
                continue;
            }
            let rendered = Rendered::new(bookmark.scene);
            let fault_side = bookmark.fault(rendered.range);
            let fault = rendered.errors(&fault_side);
            let cure = rendered.errors(&bookmark.fix(Some(&rendered.light), rendered.range));
            let size = fault_side.preset.map().map_or(COARSE, |map| map.size);
            let map = ShadowMap {
                size,
                ..ShadowMap::default()
            };
            let (usual, times) = match bookmark.kind {
                FaultKind::LightBleeding => (Pcf::new(WIDE).on(map).into(), BEYOND_BLUR),
                _ => (TechniquePreset::from(Hard {}.on(map)), BEYOND_TEXELS),
            };
            let mut usual_side = SideSettings::new(entry("hard"), rendered.range);
            usual_side.preset = usual;
            let usual = rendered.errors(&usual_side);
            let wrong = fault.false_shadow + fault.false_light;
            let ways = [&fault, &usual].map(|errors| in_its_way(bookmark.kind, errors));
            println!(
                "{:<48} {:<56} RMSE {:.4}, wrong {wrong:5.2} % ({:.2} too dark, {:.2} too light; {:.2} and {:.2} by {}); cure {:.4}",
                bookmark.label(),
                fault_side.label(),
                fault.rmse,
                fault.false_shadow,
                fault.false_light,
                usual.false_shadow,
                usual.false_light,
                usual_side.preset.technique().name(),
                cure.rmse,
            );
            let is_cured = cure.rmse < MOST_LEFT * fault.rmse;
            let is_its_own = match ways {
                [Some(fault), Some(usual)] => fault > times * usual,
                _ => true,
            };
            if wrong < LEAST_WRONG || !is_cured || !is_its_own {
                failed.push(bookmark.label());
            }
        }
        assert!(failed.is_empty(), "{failed:?}");
    }

    fn page(name: &str) -> String {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
        fs::read_to_string(docs.join(name)).expect(name)
    }

    /// Returns the failures that a text links to.
    fn linked_failures(text: &str) -> impl Iterator<Item = &str> {
        let links = text.split("live.md?failure=").skip(1);
        links.map(|after| after.split(['&', ')']).next().expect("a part"))
    }

    /// Links of pages refer to existing failures. Links of `docs/failures.md` show the technique of
    /// their section.
    #[test]
    fn pages_link_to_what_they_describe() {
        for name in linked_failures(&page("live.md")) {
            assert!(find(name).is_some(), "docs/live.md: {name}");
        }
        let text = page("failures.md");
        let mut compared = 0;
        for section in text.split("\n## ").skip(1) {
            let title = section.lines().next().unwrap_or("");
            // The row above the line of dashes describes the left image.
            let words = section.split("\n|---|---|").next().unwrap_or("");
            let left = words.lines().last().unwrap_or("");
            let left = left.split('|').nth(1).unwrap_or("");
            for name in linked_failures(section) {
                let bookmark = find(name).unwrap_or_else(|| panic!("{title}: {name}"));
                let side = bookmark.fault(1.0);
                let shown = format!("{}, {}", side.label(), side.fit.name());
                let mut quoted = left.split('`').skip(1).step_by(2);
                let is_technique = quoted
                    .next()
                    .is_none_or(|technique| shown.split(' ').next() == Some(technique));
                let has_settings = [
                    ("7x7", "7x7"),
                    ("no bias", "bias: none"),
                    ("constant bias of .02", "constant 0.02"),
                    ("variance", "vsm"),
                    ("by hand", "around the camera"),
                ]
                .iter()
                .all(|(words, setting)| !left.contains(words) || shown.contains(setting));
                assert!(
                    is_technique && has_settings,
                    "{title}: {left} against {shown}"
                );
                compared += 1;
            }
        }
        assert!(compared >= 12, "{compared}");
    }
}
