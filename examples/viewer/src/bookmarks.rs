//! Places where shadow methods fail: the scenes of the catalogue of failures, each with a setting that shows the fault and one that
//! cures it.

use crate::settings::{SideSettings, entry};
use umbrage::{
    Light,
    scenes::{self, Failure, Kind, SceneEntry},
    techniques::{Bias, ShadowMap},
};

/// Side of the maps that show faults, texels: coarse enough that faults are seen at once.
const COARSE: u32 = 512;

/// Returns the scenes of the catalogue of failures, by their rows.
pub(crate) fn all() -> Vec<(Failure, &'static SceneEntry)> {
    let of_entry = |entry| Some((provoked(entry)?, entry));
    let mut out: Vec<_> = scenes::all().iter().filter_map(of_entry).collect();
    out.sort_by_key(|(failure, _)| failure.row());
    out
}

/// Returns what a built-in scene provokes; none if it is no scene of the catalogue.
pub(crate) fn failure_of(scene: &str) -> Option<Failure> {
    scenes::find(scene).and_then(provoked)
}

fn provoked(entry: &SceneEntry) -> Option<Failure> {
    match entry.kind {
        Kind::Failure(failure) => Some(failure),
        _ => None,
    }
}

/// Returns a setting that shows the fault.
pub(crate) fn fault(failure: Failure, range: f32) -> SideSettings {
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
        Failure::FineDetail
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

/// Returns a setting that has no fault for a light.
pub(crate) fn cure(light: Option<&Light>, range: f32) -> SideSettings {
    let is_ideal = light.is_none_or(Light::is_ideal);
    let name = if is_ideal { "exact" } else { "soft" };
    SideSettings::new(entry(name), range)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_failure_has_a_scene_and_another_setting_than_its_cure() {
        let all = all();
        assert!(all.len() > 20, "{}", all.len());
        for (failure, entry) in all {
            let light = (entry.build)().lights.first().copied();
            assert_ne!(
                fault(failure, 1.0),
                cure(light.as_ref(), 1.0),
                "{}",
                entry.name
            );
        }
    }
}
