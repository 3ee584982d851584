//! Places where shadow methods fail: the scenes of the catalogue of failures, still or in motion, each with a setting that shows the
//! fault and one that cures it.

use crate::settings::{FitKind, SideSettings, entry};
use umbrage::{
    Light,
    scenes::{
        self, Failure, Kind, SceneEntry,
        motion::{Motion, MovingScene},
    },
    techniques::{Bias, ShadowMap},
};

/// Side of the maps that show faults, texels: coarse enough that faults are seen at once.
pub(crate) const COARSE: u32 = 512;
/// Maps of a sun whose place follows the camera.
const CASCADES: u32 = 3;

/// A place where shadow methods fail.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bookmark {
    /// Row of the catalogue of failures.
    pub row: u8,
    pub name: &'static str,
    pub summary: &'static str,
    /// The built-in scene.
    pub scene: &'static str,
    fails: Fails,
}

/// When it fails.
#[derive(Clone, Copy, Debug)]
enum Fails {
    Still(Failure),
    InMotion(MovingScene),
}

/// Returns all places, by their rows.
pub(crate) fn all() -> Vec<Bookmark> {
    let still = scenes::all().iter().filter_map(of_entry);
    // The renderer's casters stay where they are.
    let moving = MovingScene::ALL
        .into_iter()
        .filter(|moving| moving.motion != Motion::Casters);
    let mut out: Vec<_> = still.chain(moving.map(of_moving)).collect();
    out.sort_by_key(|bookmark| bookmark.row);
    out
}

/// Returns the place of this name; none if there is none.
pub(crate) fn find(name: &str) -> Option<Bookmark> {
    all().into_iter().find(|bookmark| bookmark.name == name)
}

fn of_entry(entry: &'static SceneEntry) -> Option<Bookmark> {
    let Kind::Failure(failure) = entry.kind else {
        return None;
    };
    Some(Bookmark {
        row: failure.row(),
        name: entry.name,
        summary: entry.summary,
        scene: entry.name,
        fails: Fails::Still(failure),
    })
}

fn of_moving(moving: MovingScene) -> Bookmark {
    Bookmark {
        row: moving.row,
        name: moving.name,
        summary: moving.motion.label(),
        scene: moving.scene,
        fails: Fails::InMotion(moving),
    }
}

impl Bookmark {
    /// Returns what moves; none if nothing does.
    pub(crate) const fn moving(&self) -> Option<MovingScene> {
        match self.fails {
            Fails::Still(_) => None,
            Fails::InMotion(moving) => Some(moving),
        }
    }

    /// Returns a setting that shows the fault. `range` is how far a camera sees, metres.
    pub(crate) fn fault(&self, range: f32) -> SideSettings {
        match self.fails {
            Fails::Still(failure) => still_fault(failure, range),
            Fails::InMotion(moving) => moving_map(FitKind::Tight, &moving),
        }
    }

    /// Returns a setting that has no fault for a light. `range` is how far a camera sees, metres.
    pub(crate) fn cure(&self, light: Option<&Light>, range: f32) -> SideSettings {
        match self.fails {
            // Maps of a sun that turns change, however they lie.
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

fn still_fault(failure: Failure, range: f32) -> SideSettings {
    let (technique, bias) = match failure {
        // Too little bias: surfaces shadow themselves.
        Failure::LowSun
        | Failure::DistantReceivers
        | Failure::Relief
        | Failure::LowPoly
        | Failure::Scale
        | Failure::Stairs => ("hard", Some(Bias::NONE)),
        // Too much: shadows part from what throws them.
        Failure::ThinContact | Failure::NearContact | Failure::ThinSlices => {
            ("hard", Some(Bias::CONSTANT))
        }
        // Light gets in where walls meet.
        Failure::SealedRoom | Failure::RoomCorner => ("hard", Some(Bias::FRONT_CULL)),
        // Casters that are not closed have no second surface.
        Failure::OpenShell | Failure::BrokenMesh => ("second_depth", None),
        // Penumbrae of one width, or from one blocker.
        Failure::RisingHeights => ("pcf", None),
        Failure::TwoBlockers | Failure::Canopy | Failure::SmallLight => ("pcss", None),
        // Moments of two blockers say less than each of them.
        Failure::LightBleeding => ("vsm", None),
        Failure::FineDetail
        | Failure::CutOut
        | Failure::Landscape
        | Failure::FarFromOrigin
        | Failure::IntoLight
        | Failure::CubeSeams
        | Failure::TwoLights
        | Failure::CasterAtLight
        | Failure::EyeInUmbra
        | Failure::ManyVolumes
        | Failure::LongRange
        | Failure::LightAlongUp
        | Failure::Nothing
        | Failure::CasterOutOfView
        | Failure::ConeRim
        | Failure::OtherProjection => ("hard", None),
    };
    let mut out = SideSettings::new(entry(technique), range);
    if let Some(own) = out.preset.map().copied() {
        out.preset = out.preset.with_map(ShadowMap {
            size: COARSE,
            bias: bias.unwrap_or(own.bias),
            ..own
        });
    }
    out
}

fn without_map(light: Option<&Light>, range: f32) -> SideSettings {
    let is_ideal = light.is_none_or(Light::is_ideal);
    let name = if is_ideal { "exact" } else { "soft" };
    SideSettings::new(entry(name), range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::{Geometry, View};

    #[test]
    fn cures_of_scenes_with_holes_know_holes() {
        let mut with_holes = 0;
        for bookmark in all() {
            let entry = scenes::find(bookmark.scene).expect(bookmark.scene);
            let scene = (entry.build)();
            let geometry = Geometry::bake(&scene).expect("built in");
            if geometry.has_cut_out_casters() {
                let cure = bookmark.cure(scene.lights.first(), 1.0);
                let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
                let recipe = cure.technique(&scene.lights[0]).recipe(&view);
                assert!(recipe.is_ok(), "{}: {recipe:?}", bookmark.name);
                with_holes += 1;
            }
        }
        assert!(with_holes > 0, "no bookmark has holes");
    }

    #[test]
    fn each_failure_has_a_scene_and_another_setting_than_its_cure() {
        let all = all();
        assert!(all.len() > 30, "{}", all.len());
        for bookmark in all {
            let entry = scenes::find(bookmark.scene).expect(bookmark.scene);
            let light = (entry.build)().lights.first().copied();
            assert_ne!(
                bookmark.fault(1.0),
                bookmark.cure(light.as_ref(), 1.0),
                "{}",
                bookmark.name
            );
            assert_eq!(
                find(bookmark.name).map(|found| found.row),
                Some(bookmark.row)
            );
        }
    }
}
