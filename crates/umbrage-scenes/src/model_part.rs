//! Parts of a model.

use umbrage_core::Instance;
use umbrage_core::glam::Affine3A;

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
    pub(crate) model_from_mesh: Affine3A,
}

impl ModelPart {
    /// Creates a part for a mesh without a transform, which casts shadows.
    pub(crate) fn new(mesh: usize, material: Option<usize>) -> Self {
        Self {
            mesh,
            material,
            casts: true,
            model_from_mesh: Affine3A::IDENTITY,
        }
    }

    /// Returns the instance of a model at the world's origin.
    pub(crate) fn instance(&self) -> Instance {
        Instance {
            material: self.material,
            casts: self.casts,
            ..Instance::new(self.mesh, self.model_from_mesh)
        }
    }

    /// Returns the mesh's placement in the world for a placement of the model, multiplied in 64
    /// bits and rounded once.
    pub(crate) fn placement_of(&self, world_from_model: Affine3A) -> Affine3A {
        // Keep the signs of zeros.
        if self.model_from_mesh == Affine3A::IDENTITY {
            return world_from_model;
        }
        let outer = world_from_model.as_daffine3();
        let inner = self.model_from_mesh.as_daffine3();
        (outer * inner).as_affine3a()
    }
}
