//! Tests of sets whose casters are relative to an anchor, when the anchor changes ("hops").

use glam::{Affine3A, DAffine3, DQuat, DVec3, UVec2, Vec3};
use proptest::{collection::vec, prelude::*, test_runner::RngSeed};
use std::sync::Arc;
use umbrage_core::{Anchor, Camera, Cascades, Fit, Layout, Light, ShadowTechnique};
use umbrage_techniques::{Exact, Hard, MapFilter as _, Pcf, ShadowMap};
use umbrage_tests::{
    adapter::device,
    foreign,
    light_program::{Forward, ForwardProgram},
};
use umbrage_wgpu::{CasterId, LightId, LightSet, SetBudget, SetFrame, ShadowedLight, StillLayers};
use wgpu::BufferUsages;

/// Position of the scene in world space, which is not a multiple of a power of two.
const PLACE: DVec3 = DVec3::new(1e6 + 0.1, 40.3, -2e6 - 0.7);
/// Initial position of the eye, whose anchor is one hop away from that of the scene.
const START: DVec3 = DVec3::new(1e6 - 1900.0, 40.3, -2e6 - 0.7);

/// A light: its position relative to the scene, and its technique.
type LampPlace = (DVec3, usize);

/// A set, and the program's record of the world.
struct World {
    program: ForwardProgram,
    set: LightSet,
    casters: Vec<(CasterId, DAffine3)>,
    lights: Vec<(LightId, LampPlace)>,
    eye: DVec3,
    anchor: Anchor,
}

fn map(fit: Fit, layout: Layout) -> ShadowMap {
    ShadowMap {
        size: 64,
        fit,
        layout,
        ..ShadowMap::default()
    }
}

/// Returns a sun with cascades that follow the camera, or a spot light.
fn light(lamp: &LampPlace, anchor: Anchor) -> ShadowedLight {
    let (place, kind) = *lamp;
    let technique: Arc<dyn ShadowTechnique> = match kind {
        0 => Arc::new(Pcf::new(1).on(map(
            Fit::AroundCamera { range: 30.0 },
            Layout::Cascades(Cascades::default()),
        ))),
        1 => Arc::new(Exact::default()),
        _ => Arc::new(Hard {}.on(map(Fit::Tight, Layout::Auto))),
    };
    let light = if kind == 0 {
        Light::Directional {
            direction: -place.as_vec3(),
            angular_diameter: 0.0,
        }
    } else {
        Light::Spot {
            position: anchor.position(PLACE + place),
            direction: Vec3::NEG_Y,
            inner: 0.6,
            outer: 0.8,
            radius: 0.0,
        }
    };
    ShadowedLight {
        light,
        technique,
        priority: 1.0,
    }
}

impl World {
    /// Creates a set at the anchor of an eye, with triangles and lights at these positions,
    /// relative to [`PLACE`].
    fn new(eye: DVec3, budget: SetBudget, places: &[DVec3], lamps: &[LampPlace]) -> Self {
        let program = ForwardProgram::floor(device(), UVec2::new(64, 48));
        let mut set = program.set(budget, StillLayers::Auto);
        // Make copies free, so that layers with still and moving casters are always split.
        set.assume_prices(1.0, 1e-9);
        let corners = [[-0.8_f32, 0.0, -0.8], [0.8, 0.1, -0.8], [0.0, 0.4, 0.8]];
        let usage = BufferUsages::VERTEX | BufferUsages::STORAGE;
        let mesh = foreign::add_triangle(program.d, &mut set, usage, corners);
        let anchor = Anchor::nearest_to(eye).expect("finite");
        let mut casters = Vec::new();
        for place in places {
            let turn = DQuat::from_rotation_y(place.x);
            let placed = DAffine3::from_rotation_translation(turn, PLACE + *place);
            let id = set.add_caster(mesh, anchor.placement(&placed));
            casters.push((id.expect("valid"), placed));
        }
        let mut lights = Vec::new();
        for lamp in lamps {
            let id = set.add_light(light(lamp, anchor));
            lights.push((id.expect("valid"), *lamp));
        }
        Self {
            program,
            set,
            casters,
            lights,
            eye,
            anchor,
        }
    }

    fn frame(&mut self) {
        let eye = self.anchor.position(self.eye);
        let target = self.anchor.position(self.eye - DVec3::new(0.3, 4.0, 9.0));
        let size = UVec2::new(64, 48);
        let camera = Camera::perspective(eye, target, Vec3::Y, 0.9, [0.1, 100.0], size);
        let frame = SetFrame {
            camera: &camera.expect("valid"),
            geometry: None,
        };
        self.program.update(&mut self.set, &frame);
    }

    /// Moves the eye above the scene, and the anchor with it. Returns whether the anchor changed.
    fn walk(&mut self) -> bool {
        self.eye = arrived_position();
        let anchor = self.anchor.kept_for(self.eye).expect("finite");
        let has_hopped = anchor != self.anchor;
        self.anchor = anchor;
        has_hopped
    }

    fn placements(&self) -> Vec<(CasterId, Affine3A)> {
        let relative = |(id, placed): &(CasterId, DAffine3)| (*id, self.anchor.placement(placed));
        self.casters.iter().map(relative).collect()
    }

    /// Updates placements after a change of the anchor, like a program.
    fn rebase(&mut self) {
        for (id, placement) in self.placements() {
            self.set.rebase_caster(id, placement).expect("is there");
        }
        self.set_lights();
    }

    /// Moves everything to the anchor: as a hop, or as moves of all casters.
    fn hop(&mut self, is_reported: bool) {
        if is_reported {
            self.rebase();
            return;
        }
        for (id, placement) in self.placements() {
            self.set.move_caster(id, placement).expect("is there");
        }
        self.set_lights();
    }

    fn set_lights(&mut self) {
        for (id, lamp) in &self.lights {
            let light = light(lamp, self.anchor).light;
            self.set.set_light(*id, light).expect("is there");
        }
    }

    /// Returns the mask of each light on a floor under the scene.
    fn masks(&self) -> Vec<Vec<f32>> {
        let mut positions: Vec<[f32; 4]> = Vec::new();
        let size = self.program.size();
        for y in 0..size.y {
            for x in 0..size.x {
                let [x, z] = [(x, size.x), (y, size.y)]
                    .map(|(i, side)| (f64::from(i) - 0.5 * f64::from(side)) * 0.25);
                let seen = self.anchor.position(PLACE + DVec3::new(x, 0.0, z));
                positions.push(seen.extend(1.0).to_array());
            }
        }
        let normals = vec![Vec3::Y.extend(0.0).to_array(); positions.len()];
        let triangles = vec![u32::MAX; positions.len()];
        let d = self.program.d;
        let floor = ForwardProgram::of_texels(d, size, &positions, &normals, &triangles);
        let mut forward = Forward::default();
        let mask = |(id, _): &(LightId, LampPlace)| {
            let index = self.set.index_of(*id).expect("is there");
            forward.mask(&floor, &self.set, index)
        };
        self.lights.iter().map(mask).collect()
    }
}

fn arrived_position() -> DVec3 {
    PLACE + DVec3::new(0.2, 5.0, 9.0)
}

fn count_differing(a: &[Vec<f32>], b: &[Vec<f32>]) -> usize {
    let pixels = a.iter().flatten().zip(b.iter().flatten());
    pixels.filter(|(a, b)| a.to_bits() != b.to_bits()).count()
}

fn dark(masks: &[Vec<f32>]) -> usize {
    masks.iter().flatten().filter(|&&v| v < 1.0).count()
}

fn places() -> impl Strategy<Value = DVec3> {
    (-6.0..6.0_f64, 1.0..3.0_f64, -4.0..4.0_f64).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// Some lights, ordered by their techniques: each order has another text, which takes seconds to
/// compile.
fn lamps() -> impl Strategy<Value = Vec<LampPlace>> {
    let above = (-3.0..3.0_f64, 6.0..9.0_f64, -3.0..3.0_f64);
    let lamp = (above, 0..3_usize).prop_map(|((x, y, z), kind)| (DVec3::new(x, y, z), kind));
    vec(lamp, 1..4).prop_map(|mut lamps| {
        lamps.sort_by_key(|(_, kind)| *kind);
        lamps
    })
}

/// Budget of one redrawn layer a frame, so that lights without need would wait.
const FEW_REDRAWS: SetBudget = SetBudget {
    bytes: 256 << 20,
    redraws: 1,
};

#[test]
fn after_a_hop_shadows_are_those_of_a_set_made_there() {
    let config = ProptestConfig {
        cases: 24,
        rng_seed: RngSeed::Fixed(5),
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let [in_shadow, spoilt] = std::array::from_fn(|_| std::cell::Cell::new(0));
    proptest!(config, |(places in vec(places(), 2..12), lamps in lamps())| {
        let mut kept = World::new(START, FEW_REDRAWS, &places, &lamps);
        for _ in 0..10 {
            kept.frame();
        }
        // Start from the old anchor, with the eye at its final position.
        kept.eye = arrived_position();
        for _ in 0..10 {
            kept.frame();
        }
        prop_assert!(kept.walk(), "the anchor stays");
        kept.rebase();
        kept.frame();
        let after_hop = kept.masks();
        let mut rebuilt = World::new(arrived_position(), SetBudget::default(), &places, &lamps);
        rebuilt.frame();
        let made_there = rebuilt.masks();
        prop_assert_eq!(count_differing(&after_hop, &made_there), 0, "{:?}", lamps);
        in_shadow.set(in_shadow.get() + dark(&made_there));
        // Negative control: one caster keeps its placement relative to the old anchor.
        let (forgotten, placed) = kept.casters[0];
        let before = Anchor::nearest_to(START).expect("finite").placement(&placed);
        kept.set.rebase_caster(forgotten, before).expect("is there");
        kept.frame();
        spoilt.set(spoilt.get() + usize::from(count_differing(&kept.masks(), &made_there) > 0));
    });
    let [in_shadow, spoilt] = [in_shadow, spoilt].map(|count| count.get());
    assert!(in_shadow > 2000, "only {in_shadow} pixels in shadow");
    assert!(spoilt >= 18, "only {spoilt} of 24 wrong sets are detected");
}

const FOUR_LAMPS: [LampPlace; 4] = [
    (DVec3::new(-3.0, 7.0, 0.3), 2),
    (DVec3::new(0.5, 8.0, -0.3), 2),
    (DVec3::new(3.0, 7.0, 0.2), 2),
    (DVec3::new(3.0, 8.0, 1.0), 0),
];
const THREE_PLACES: [DVec3; 3] = [
    DVec3::new(-3.0, 2.0, 0.3),
    DVec3::new(0.4, 1.5, 0.2),
    DVec3::new(3.0, 2.5, -0.3),
];

/// A budget of redraws may not delay redraws after a hop, as it may after moves.
#[test]
fn no_light_waits_after_a_hop() {
    let mut rebuilt = World::new(
        arrived_position(),
        SetBudget::default(),
        &THREE_PLACES,
        &FOUR_LAMPS,
    );
    rebuilt.frame();
    let made_there = rebuilt.masks();
    assert!(dark(&made_there) > 100);
    for is_reported in [true, false] {
        let mut kept = World::new(START, FEW_REDRAWS, &THREE_PLACES, &FOUR_LAMPS);
        for _ in 0..10 {
            kept.frame();
        }
        assert!(kept.walk());
        kept.hop(is_reported);
        kept.frame();
        let waiting = kept.set.report().waiting;
        let other = count_differing(&kept.masks(), &made_there);
        assert_eq!(
            (waiting > 0, other > 0),
            (!is_reported, !is_reported),
            "{other}"
        );
        // Nothing is redrawn after the hop has finished.
        for _ in 0..10 {
            kept.frame();
        }
        assert_eq!(kept.set.report().redrawn, 0);
        assert_eq!(count_differing(&kept.masks(), &made_there), 0);
    }
}

/// A hop is not a motion: still casters keep separate layers from moving ones.
#[test]
fn casters_that_were_still_stay_still() {
    let mut bytes = Vec::new();
    for is_reported in [true, false] {
        let lamps = &FOUR_LAMPS[..1];
        let mut kept = World::new(START, SetBudget::default(), &THREE_PLACES, lamps);
        kept.frame();
        assert!(kept.walk());
        kept.hop(is_reported);
        kept.frame();
        // Move one caster by itself.
        let (id, placed) = &mut kept.casters[0];
        placed.translation.y += 0.25;
        let placement = kept.anchor.placement(placed);
        kept.set.move_caster(*id, placement).expect("is there");
        kept.frame();
        bytes.push(kept.set.map_bytes());
    }
    let layer = 4 * 64 * 64;
    assert_eq!(bytes, [2 * layer, layer]);
}
