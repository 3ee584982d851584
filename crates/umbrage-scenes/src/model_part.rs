//! What a model is made of.

use umbrage_core::Instance;
use umbrage_core::glam::Affine3A;

/// A mesh of a scene, as a model places it and lets it look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ModelPart {
    /// Index of a mesh of the scene; several parts may show one.
    pub(crate) mesh: usize,
    /// Index of a material of the scene.
    pub(crate) material: Option<usize>,
    /// Whether it throws shadows.
    pub(crate) casts: bool,
    /// Where the mesh stands in the model.
    pub(crate) model_from_mesh: Affine3A,
}

impl ModelPart {
    /// A mesh that is the model's own, throws shadows, and stands where its vertices say.
    pub(crate) fn new(mesh: usize, material: Option<usize>) -> Self {
        Self {
            mesh,
            material,
            casts: true,
            model_from_mesh: Affine3A::IDENTITY,
        }
    }

    /// Returns the instance of a model that stands at the world's origin.
    pub(crate) fn instance(&self) -> Instance {
        Instance {
            material: self.material,
            casts: self.casts,
            ..Instance::new(self.mesh, self.model_from_mesh)
        }
    }

    /// Returns where the mesh stands in the world, given where the model stands: multiplied in 64
    /// bits, rounded once.
    pub(crate) fn placed(&self, world_from_model: Affine3A) -> Affine3A {
        // No zero changes its sign.
        if self.model_from_mesh == Affine3A::IDENTITY {
            return world_from_model;
        }
        let outer = world_from_model.as_daffine3();
        let inner = self.model_from_mesh.as_daffine3();
        (outer * inner).as_affine3a()
    }
}
