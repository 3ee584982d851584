//! The light set of the scene: the setup that both renderers share, and the first steps of every
//! frame.

use crate::renderer::{Boxes, Graphics, VERTEX_BYTES};
use anyhow::Result;
use std::sync::Arc;
use umbrage::{
    Aabb, Light, ShadowTechnique,
    glam::{Affine3A, Vec3},
    gpu::{
        CasterId, CasterMesh, LightId, LightSet, LightSetOptions, PositionFormat, SetFrame,
        ShadowedLight, VertexLayout,
    },
};

/// A light set with the boxes and lights of a scene.
pub struct BoxShadows {
    /// The set.
    pub set: LightSet,
    /// The casters, one for each placement.
    pub casters: Vec<CasterId>,
    /// The lights, in the order of the scene's.
    pub lights: Vec<LightId>,
}

impl BoxShadows {
    /// Adds all boxes to a new set.
    pub fn new(graphics: &Graphics, boxes: &Boxes) -> Result<Self> {
        // The bind group that the set's WGSL declares; the program has group 0.
        let options = LightSetOptions {
            group: 1,
            ..LightSetOptions::default()
        };
        let mut set = LightSet::new(&graphics.device, &graphics.queue, options)?;

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
            // The bounds of the mesh's positions, as they are in the buffer. Casters outside a map
            // are not drawn into it.
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
        Ok(Self {
            set,
            casters,
            lights: Vec::new(),
        })
    }

    /// Adds lights that share a technique.
    pub fn add_lights(
        &mut self,
        lights: &[Light],
        technique: &Arc<dyn ShadowTechnique>,
    ) -> Result<()> {
        for &light in lights {
            let id = self.set.add_light(ShadowedLight {
                light,
                technique: Arc::clone(technique),
                // Lights of higher priority come first where a budget can't serve all.
                priority: 1.0,
            })?;
            self.lights.push(id);
        }
        Ok(())
    }

    /// Moves all casters.
    pub fn place(&mut self, placements: &[Affine3A]) -> Result<()> {
        // Report every move. Casters that don't move are not redrawn.
        for (&caster, &world_from_local) in self.casters.iter().zip(placements) {
            self.set.move_caster(caster, world_from_local)?;
        }
        Ok(())
    }

    /// Determines the work for a frame.
    pub fn prepare(&mut self, boxes: &Boxes) -> Result<()> {
        let frame = SetFrame {
            camera: &boxes.scene.camera,
            geometry: None,
        };
        self.set.prepare(&frame)?;
        Ok(())
    }
}
