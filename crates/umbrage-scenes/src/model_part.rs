//! Parts of a model.

use crate::far::Box64;
use umbrage_core::glam::{Affine3A, DAffine3, DVec3};
use umbrage_core::{Anchor, Instance, Mesh};

/// A mesh of a scene, with the model's placement and material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ModelPart {
    /// Index of a mesh of the scene. Several parts may share it.
    pub(crate) mesh: usize,
    /// Index of a material of the scene.
    pub(crate) material: Option<usize>,
    /// `true` if it casts shadows.
    pub(crate) casts: bool,
    /// Placement of the mesh in the model.
    pub(crate) model_from_mesh: DAffine3,
}

impl ModelPart {
    /// Creates a part for a mesh that is only moved by `offset`, which casts shadows.
    pub(crate) fn new(mesh: usize, material: Option<usize>, offset: DVec3) -> Self {
        Self {
            mesh,
            material,
            casts: true,
            model_from_mesh: DAffine3::from_translation(offset),
        }
    }

    /// Returns the instance of a model at the world's origin, relative to an anchor.
    pub(crate) fn instance(&self, anchor: Anchor) -> Instance {
        Instance {
            material: self.material,
            casts: self.casts,
            ..Instance::new(self.mesh, anchor.placement(&self.model_from_mesh))
        }
    }

    /// Returns the mesh's placement for a placement of the model, relative to an anchor:
    /// multiplied in 64 bits and rounded once.
    pub(crate) fn placement_of(&self, world_from_model: &DAffine3, anchor: Anchor) -> Affine3A {
        // Keep the signs of zeros.
        if self.model_from_mesh == DAffine3::IDENTITY {
            return anchor.placement(world_from_model);
        }
        anchor.placement(&(*world_from_model * self.model_from_mesh))
    }

    /// Adds the part's vertices to a box of the model.
    pub(crate) fn add_to(&self, bounds: &mut Box64, meshes: &[Mesh]) {
        for position in &meshes[self.mesh].positions {
            bounds.add(self.model_from_mesh.transform_point3(position.as_dvec3()));
        }
    }
}
