//! Scenes: meshes, instances of them, lights and cameras. Fields are public; `validate` reports
//! errors.

pub(crate) mod anchor;
pub(crate) mod camera;
pub(crate) mod light;
pub(crate) mod light_marker;
pub mod light_sample;
pub(crate) mod material;

use crate::{
    invalid::{Invalid, finite},
    scene::{
        anchor::Anchor,
        camera::Camera,
        light::Light,
        material::{Material, Texture},
    },
};
use glam::{Affine3A, Vec2, Vec3, Vec4};

/// Triangles in local space. Right-handed; counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name for error messages.
    pub name: String,
    /// Vertex positions, metres.
    pub positions: Vec<Vec3>,
    /// Shading normals, one per vertex, any length. If empty, they are averaged from the triangles.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, one per vertex, origin top left; or empty.
    pub uvs: Vec<Vec2>,
    /// Tangents for normal maps, one per vertex: xyz along growing u, w the handedness (bitangent =
    /// w n x t); or empty.
    pub tangents: Vec<Vec4>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Returns a mesh without normals and texture coordinates.
    ///
    /// # Errors
    /// Errors if [`Mesh::validate`] does.
    pub fn new(
        name: impl Into<String>,
        positions: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, Invalid> {
        let mesh = Self {
            name: name.into(),
            positions,
            triangles,
            ..Self::default()
        };
        mesh.validate()?;
        Ok(mesh)
    }

    /// Checks that the mesh can be rendered.
    ///
    /// # Errors
    /// Errors with the first fault found: no triangle, arrays of unequal length, a number that is
    /// not finite, an index out of range.
    pub fn validate(&self) -> Result<(), Invalid> {
        let what = format!("mesh `{}`", self.name);
        let count = self.positions.len();
        if self.triangles.is_empty() || count == 0 {
            let help = "add at least one, or remove the mesh";
            return Err(Invalid::new(what, "has no triangles", help));
        }
        if u32::try_from(count).is_err() || u32::try_from(self.triangles.len()).is_err() {
            let why = "has over 2^32 vertices or triangles";
            return Err(Invalid::new(what, why, "split it"));
        }
        for (kind, len) in [
            ("normals", self.normals.len()),
            ("texture coordinates", self.uvs.len()),
            ("tangents", self.tangents.len()),
        ] {
            if len != 0 && len != count {
                let why = format!("has {len} {kind} for {count} vertices");
                return Err(Invalid::new(what, why, "use one per vertex or none"));
            }
        }
        self.validate_numbers()
            .map_err(|e| e.within_context(&what))?;
        for (i, triangle) in self.triangles.iter().enumerate() {
            if triangle.iter().any(|&v| v as usize >= count) {
                let why = format!("triangle {i} is {triangle:?}, but there are {count} vertices");
                let help = format!("use indices from 0 to {}", count - 1);
                return Err(Invalid::new(what, why, help));
            }
        }
        Ok(())
    }

    fn validate_numbers(&self) -> Result<(), Invalid> {
        // Format names only for values that are not finite: formatting one for each vertex is slow.
        for (i, position) in self.positions.iter().enumerate() {
            if !position.is_finite() {
                finite(&format!("vertex {i}"), &position.to_array())?;
            }
        }
        for (i, normal) in self.normals.iter().enumerate() {
            if !normal.is_finite() {
                finite(&format!("normal {i}"), &normal.to_array())?;
            }
        }
        for (i, uv) in self.uvs.iter().enumerate() {
            if !uv.is_finite() {
                finite(&format!("texture coordinate {i}"), &uv.to_array())?;
            }
        }
        for (i, tangent) in self.tangents.iter().enumerate() {
            if !tangent.is_finite() {
                finite(&format!("tangent {i}"), &tangent.to_array())?;
            }
        }
        Ok(())
    }
}

/// An instance of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Placement in the world.
    pub world_from_local: Affine3A,
    /// True if it casts shadows.
    pub casts: bool,
    /// True if it receives shadows.
    pub receives: bool,
    /// Index into [`Scene::materials`]; `None` for [`Material::default`].
    pub material: Option<usize>,
}

impl Instance {
    /// Returns an instance that casts and receives.
    pub fn new(mesh: usize, world_from_local: Affine3A) -> Self {
        Self {
            mesh,
            world_from_local,
            casts: true,
            receives: true,
            material: None,
        }
    }
}

/// Greatest length of a scene's name, bytes: most file systems allow names of 255, and reports add
/// a few letters.
pub const MAX_NAME_BYTES: usize = 200;

/// A scene. Comparisons use the first light and the first camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Short name, at most [`MAX_NAME_BYTES`] bytes, valid as a file name once blanks are replaced.
    pub name: String,
    /// Meshes.
    pub meshes: Vec<Mesh>,
    /// Instances of the meshes.
    pub instances: Vec<Instance>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Textures of the materials.
    pub textures: Vec<Texture>,
    /// Lights.
    pub lights: Vec<Light>,
    /// Cameras.
    pub cameras: Vec<Camera>,
    /// Origin of all positions in the scene's files. Camera files for the scene share it.
    pub anchor: Anchor,
    /// Contents of the scene's files that readers ignore, one line each.
    pub notices: Vec<String>,
}

impl Scene {
    /// Checks that the scene can be rendered. A scene without instances is valid: everything is
    /// lit.
    ///
    /// # Errors
    /// Errors with the first fault found, with the scene's name.
    pub fn validate(&self) -> Result<(), Invalid> {
        self.validate_name()?;
        self.validate_parts()
            .map_err(|e| e.within_context(format!("scene `{}`", self.name)))
    }

    fn validate_name(&self) -> Result<(), Invalid> {
        let length = self.name.len();
        if length <= MAX_NAME_BYTES {
            return Ok(());
        }
        let start = &self.name[..self.name.floor_char_boundary(20)];
        let why = format!("has a name of {length} bytes, which reports use as a folder name");
        Err(Invalid::new(
            format!("scene `{start}..`"),
            why,
            format!("use at most {MAX_NAME_BYTES}"),
        ))
    }

    fn validate_parts(&self) -> Result<(), Invalid> {
        self.meshes.iter().try_for_each(Mesh::validate)?;
        self.textures.iter().try_for_each(Texture::validate)?;
        for (i, material) in self.materials.iter().enumerate() {
            material
                .validate(self.textures.len())
                .map_err(|e| e.within_context(format!("material {i}")))?;
        }
        for (i, instance) in self.instances.iter().enumerate() {
            self.validate_instance(instance)
                .map_err(|e| e.within_context(format!("object {i}")))?;
        }
        self.lights.iter().try_for_each(Light::validate)?;
        self.cameras.iter().try_for_each(Camera::validate)
    }

    fn validate_instance(&self, instance: &Instance) -> Result<(), Invalid> {
        if instance.mesh >= self.meshes.len() {
            let why = format!("refers to mesh {} of {}", instance.mesh, self.meshes.len());
            return Err(Invalid::new(
                "instance",
                why,
                "use the index of a mesh of this scene",
            ));
        }
        self.validate_material(instance)?;
        finite("matrix", &instance.world_from_local.to_cols_array())?;
        let det = instance.world_from_local.matrix3.as_dmat3().determinant();
        if det == 0.0 {
            return Err(Invalid::new(
                "matrix",
                "is singular: it flattens the object",
                "use a scale other than zero",
            ));
        }
        Ok(())
    }

    fn validate_material(&self, instance: &Instance) -> Result<(), Invalid> {
        let Some(id) = instance.material else {
            return Ok(());
        };
        let Some(material) = self.materials.get(id) else {
            let why = format!("refers to material {id} of {}", self.materials.len());
            return Err(Invalid::new(
                "instance",
                why,
                "use the index of a material of this scene",
            ));
        };
        let mesh = &self.meshes[instance.mesh];
        let textured = material.diffuse_texture.or(material.normal_map).is_some()
            || material.displacement.is_some()
            || material.alpha.is_some();
        if textured && mesh.uvs.is_empty() {
            let why = "has no texture coordinates, but its material has a texture";
            return Err(Invalid::new(
                format!("mesh `{}`", mesh.name),
                why,
                "add uvs, or remove the textures",
            ));
        }
        if material.normal_map.is_some() && mesh.tangents.is_empty() {
            let why = "has no tangents, but its material has a normal map";
            return Err(Invalid::new(
                format!("mesh `{}`", mesh.name),
                why,
                "add them with `umbrage_scenes::with_tangents`",
            ));
        }
        Ok(())
    }
}
