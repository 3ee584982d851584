//! Tests of a light set with a test technique: its masks, and the states of its lights.

use crate::{embedded::Embedded, foreign::read, scene::BackendScene};
use glam::{Affine3A, Vec3};
use std::sync::Arc;
use umbrage_core::{Aabb, Light, Recipe, RecipeError, ShadowTechnique, View};
use umbrage_wgpu::{
    CasterId, CasterMesh, LightId, LightSet, LightSetOptions, MaskFormat, MaskInputs,
    MaskReceivers, SetBudget, SetFrame, SetReport, ShadowedLight, Unserved, wgpu::TextureView,
};

/// A technique with one map of this many texels a side, or 0 to support no light.
#[derive(Debug)]
struct OneMap(u32);

/// Bytes of a map of 64 texels a side.
const MAP_BYTES: u64 = 4 * 64 * 64;

impl ShadowTechnique for OneMap {
    fn name(&self) -> &'static str {
        "one map"
    }

    fn recipe(&self, _: &View<'_>) -> Result<Recipe, RecipeError> {
        if self.0 == 0 {
            return Err(RecipeError::unsupported_because(
                "it has no texels".to_owned(),
            ));
        }
        Ok(BackendScene::new().recipe(self.0))
    }

    fn follows_camera(&self, _: &Light) -> bool {
        false
    }
}

/// A set with the casters of a program.
struct Lit {
    e: Embedded,
    set: LightSet,
    caster: CasterId,
}

impl Lit {
    fn new(options: LightSetOptions) -> Self {
        let e = Embedded::new();
        let mut set = LightSet::new(&e.foreign.device, &e.foreign.queue, options)
            .expect("the group is there");
        let casters = e.casters();
        let placement = casters.world_from_local.expect("is placed");
        let mesh = CasterMesh {
            label: "floor and plate",
            vertices: casters.vertices,
            layout: casters.layout,
            indices: casters.indices,
            range: casters.range.clone(),
            base_vertex: 0,
            bounds: Aabb {
                min: Vec3::splat(-16.0),
                max: Vec3::splat(16.0),
            },
        };
        let mesh = set.add_mesh(&mesh).expect("valid");
        let caster = set.add_caster(mesh, placement).expect("finite");
        Self { e, set, caster }
    }

    fn add(&mut self, side: u32, priority: f32) -> LightId {
        let light = ShadowedLight {
            light: self.e.stage.light,
            technique: Arc::new(OneMap(side)),
            priority,
        };
        self.set.add_light(light).expect("valid")
    }

    /// Prepares a frame and submits it. Returns the report.
    fn frame(&mut self) -> SetReport {
        let frame = SetFrame {
            camera: &self.e.stage.camera,
            geometry: None,
        };
        let report = *self.set.prepare(&frame).expect("valid");
        let mut encoder = self.e.foreign.encoder();
        self.set.encode(&mut encoder).expect("it was prepared");
        self.e.foreign.queue.submit([encoder.finish()]);
        report
    }

    fn unserved_lights(&self) -> Vec<(LightId, Unserved)> {
        self.set.unserved_lights().collect()
    }

    fn mask(&mut self, light: LightId) -> Vec<f32> {
        let inputs = MaskInputs {
            size: self.e.size(),
            receivers: MaskReceivers::Positions(self.e.receivers()),
            lights: &[light],
            format: MaskFormat::Float32,
        };
        self.set.prepare_masks(&inputs).expect("valid");
        let mut encoder = self.e.foreign.encoder();
        let mask: &TextureView = self.set.encode_masks(&mut encoder).expect("prepared");
        read(&self.e.foreign, encoder, mask.texture())
    }
}

#[test]
fn a_set_has_the_masks_of_the_renderer() {
    for (group, prefix) in [(0, ""), (1, "sun_"), (2, "")] {
        let mut lit = Lit::new(LightSetOptions {
            group,
            prefix: prefix.to_owned(),
            ..LightSetOptions::default()
        });
        let light = lit.add(64, 1.0);
        assert_eq!(lit.frame().redrawn, 1);
        assert!(lit.set.wgsl().contains(&format!("fn {prefix}shadow_on(")));
        assert!(!lit.set.wgsl().contains("override"));
        let expected = lit.e.mask().to_vec();
        assert!(expected.contains(&0.0) && expected.contains(&1.0));
        assert_eq!(lit.mask(light), expected, "group {group}");
        assert_eq!(lit.frame(), SetReport::default(), "nothing changed");
    }
}

#[test]
fn lights_go_through_their_states() {
    let mut lit = Lit::new(LightSetOptions {
        budget: SetBudget {
            bytes: 2 * MAP_BYTES,
            redraws: 1,
        },
        ..LightSetOptions::default()
    });
    let [first, second, third] = [3.0, 2.0, 1.0].map(|priority| lit.add(64, priority));
    assert_eq!(lit.frame().redrawn, 1);
    let states = [(second, Unserved::Waiting), (third, Unserved::OverBudget)];
    assert_eq!(lit.unserved_lights(), states);
    assert_eq!(lit.frame().redrawn, 1, "the second one's turn");
    assert_eq!(lit.unserved_lights(), states[1..]);

    let refuse = lit.set.set_technique(first, Arc::new(OneMap(0)));
    refuse.expect("is there");
    lit.frame();
    let unserved = lit.unserved_lights();
    let [(refused, Unserved::Refused(why))] = &unserved[..] else {
        panic!("{unserved:?}");
    };
    assert_eq!(*refused, first);
    assert!(why.to_string().contains("it has no texels"), "{why}");
    let served = lit.mask(third);
    assert_eq!(served, lit.e.mask(), "the third one has the layer");
    assert!(lit.mask(first).iter().all(|&lit| lit == 1.0));

    let other = lit.set.set_technique(first, Arc::new(OneMap(64)));
    other.expect("is there");
    lit.frame();
    assert_eq!(
        lit.unserved_lights(),
        states[1..],
        "the first one comes first again"
    );
    lit.set.remove_light(second).expect("is there");
    lit.frame();
    assert_eq!(lit.unserved_lights(), []);

    let moved = Affine3A::from_translation(Vec3::X);
    lit.set.move_caster(lit.caster, moved).expect("is there");
    let report = lit.frame();
    assert_eq!((report.redrawn, report.waiting), (1, 1));
    assert_eq!(lit.frame().redrawn, 1, "the one that waited");
    assert_eq!(
        lit.unserved_lights(),
        [],
        "what was drawn before is shown meanwhile"
    );
}
