//! The light set of the scene: what both renderers do once, and the first steps of every frame.

use crate::renderer::{Boxes, Graphics, VERTEX_BYTES};
use anyhow::Result;
use std::sync::Arc;
use umbrage::{
    Aabb, ShadowTechnique,
    glam::{Affine3A, Vec3},
    wgpu::{
        CasterId, CasterMesh, LightId, LightSet, LightSetOptions, PositionFormat, SetFrame,
        SetLight, VertexLayout,
    },
};

/// A light set with the boxes and lights of a scene.
pub struct BoxShadows {
    /// The set.
    pub set: LightSet,
    /// One for each placement.
    pub casters: Vec<CasterId>,
    /// In the order of the scene's lights.
    pub lights: Vec<LightId>,
}

impl BoxShadows {
    /// Adds all boxes and lights to a new set.
    pub fn new(
        graphics: &Graphics,
        boxes: &Boxes,
        technique: &Arc<dyn ShadowTechnique>,
    ) -> Result<Self> {
        // The bind group that the set's WGSL declares; the program has group 0.
        let options = LightSetOptions {
            group: 1,
            ..LightSetOptions::default()
        };
        let mut set = LightSet::new(&graphics.device, options)?;

        let mesh = set.add_mesh(&CasterMesh {
            // Names the mesh in errors.
            label: "box",
            // The buffer that the program draws from itself, usage VERTEX.
            vertices: &boxes.vertices,
            layout: VertexLayout {
                format: PositionFormat::Float32x3,
                stride: VERTEX_BYTES,
                position_offset: 0,
            },
            indices: None,
            range: 0..boxes.vertex_count,
            base_vertex: 0,
            // Around the mesh's positions, as they are in the buffer: casters outside a map are not
            // drawn into it.
            bounds: Aabb {
                min: Vec3::NEG_ONE,
                max: Vec3::ONE,
            },
        })?;
        // Casters of one mesh become instances.
        let mut casters = Vec::new();
        for world_from_local in boxes.scene.placements(0.0) {
            casters.push(set.add_caster(mesh, world_from_local)?);
        }

        let mut lights = Vec::new();
        for &light in &boxes.scene.lights {
            lights.push(set.add_light(SetLight {
                light,
                technique: Arc::clone(technique),
                priority: 1.0,
            })?);
        }
        Ok(Self {
            set,
            casters,
            lights,
        })
    }

    /// Moves all casters.
    pub fn place(&mut self, placements: &[Affine3A]) -> Result<()> {
        // Say what moved. Nothing is drawn again for casters that stay.
        for (&caster, &world_from_local) in self.casters.iter().zip(placements) {
            self.set.move_caster(caster, world_from_local)?;
        }
        Ok(())
    }

    /// Finds out what has to be drawn for a frame.
    pub fn prepare(&mut self, graphics: &Graphics, boxes: &Boxes) -> Result<()> {
        let frame = SetFrame {
            camera: &boxes.scene.camera,
            geometry: None,
        };
        self.set
            .prepare(&graphics.device, &graphics.queue, &frame)?;
        Ok(())
    }
}
