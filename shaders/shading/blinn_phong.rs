//! Colour images: Blinn-Phong shading of the visible geometry. The shadow mask of any technique is
//! the light's visibility.
//!
//! `colour = emission + ambient * diffuse + visibility * light * (diffuse * n.l + specular *
//! (n.h)^s)`. Phong 1975, "Illumination for computer generated pictures"; Blinn 1977, "Models of
//! light reflection for computer synthesized pictures", for h, halfway between light and eye.
//! Shadows darken only the shadow-casting light, not ambient light or emission. All values are
//! linear; [`picture`](umbrage_core::picture) encodes sRGB.
//!
//! - Masks ignore normal maps and smooth normals. Biases follow the geometric normal, since a map
//!   stores the depth of the geometry.
//! - Shading normals are interpolated and perturbed by normal maps. But no light arrives where the
//!   *geometric* normal faces away from the light, whatever the shading normal is. Surfaces shadow
//!   themselves there, which biased maps don't detect reliably. Error metrics exclude such pixels
//!   ([`Pixel::Unlit`](umbrage_core::metrics::Pixel)), so no image may show them lit.
//! - Area lights are shaded from their centre; only their visibility accounts for the extent.
//! - The light of a spot falls off between its angles, linearly in the cosine. Light does not fall
//!   off with distance unless [`BlinnPhong::attenuation`] is set, as in the textbooks.
//!
//! Known failures: smooth normals over few triangles reveal the triangles at grazing light, since
//! visibility and the rule above follow the geometry. A highlight may end there at a straight line.

use crate::shading::{
    facing::homogeneous,
    interpolation::{INTERPOLATION, unit_or},
    lighting::{LIGHTING, attenuation, blinn, cone},
    surface::SURFACE,
    surface_tables::SurfaceTables,
    texture::TEXTURE,
};
use glam::{Vec2, Vec3, Vec4};
use std::sync::Arc;
use umbrage_core::{
    Camera, Invalid, Kernel, Light, Module, Recipe, Scene, Shade, ShadeKernel, Span, UniformBlock,
    View, invalid::not_negative, math::dot3, module, uniforms,
};

/// Lighting of a colour image. Colours are linear.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct BlinnPhong {
    /// Ambient light, which shadows don't affect; multiplied by the diffuse colour.
    pub ambient: Vec3,
    /// Colour of the light times its intensity.
    pub light: Vec3,
    /// Constant, linear (1/m) and quadratic (1/m^2) factors of `1 / (c + l d + q d^2)`, where d is
    /// the distance to the light's centre. They must not all be zero. Directional lights have no
    /// distance and don't fall off.
    pub attenuation: Vec3,
    /// Colour of pixels without geometry.
    pub background: Vec3,
}

impl Default for BlinnPhong {
    fn default() -> Self {
        Self {
            ambient: Vec3::splat(0.15),
            light: Vec3::ONE,
            attenuation: Vec3::X,
            background: Vec3::new(0.30, 0.38, 0.50),
        }
    }
}

impl BlinnPhong {
    /// Returns the shading of this view of a scene. `view.geometry` must be baked from `scene`.
    ///
    /// # Errors
    /// Errors if the view has no geometry or was baked from another scene. Errors if the scene, the
    /// light or a number of these settings is invalid.
    pub fn shading(&self, scene: &Scene, view: &View<'_>) -> Result<Shading, Invalid> {
        self.validate()
            .map_err(|e| e.within_context("Blinn-Phong shading"))?;
        scene.validate()?;
        let Some(geometry) = view.geometry else {
            return Err(Invalid::new(
                "view",
                "has no triangles to shade",
                "make it with `View::new`",
            ));
        };
        let kernel = BlinnPhongKernel {
            uniforms: self.uniforms(view)?,
            tables: SurfaceTables::new(scene, geometry)?,
        };
        Ok(Shading {
            settings: *self,
            kernel,
        })
    }

    fn validate(&self) -> Result<(), Invalid> {
        let named = [
            ("ambient", self.ambient),
            ("light", self.light),
            ("attenuation", self.attenuation),
            ("background", self.background),
        ];
        for (what, color) in named {
            for component in color.to_array() {
                not_negative(what, component)?;
            }
        }
        if self.attenuation == Vec3::ZERO {
            return Err(Invalid::new(
                "attenuation",
                "is zero, which makes the light infinite",
                "use (1, 0, 0) for no attenuation",
            ));
        }
        Ok(())
    }

    fn uniforms(&self, view: &View<'_>) -> Result<BlinnPhongUniforms, Invalid> {
        view.validate()?;
        let (axis, cone) = cone_of(view.light);
        let light = homogeneous(view.light);
        let attenuation = if light.w == 0.0 {
            Vec3::X
        } else {
            self.attenuation
        };
        Ok(BlinnPhongUniforms {
            eye: eye_of(view.camera),
            light,
            axis: axis.extend(0.0),
            color: self.light.extend(0.0),
            ambient: self.ambient.extend(0.0),
            attenuation: attenuation.extend(0.0),
            cone,
        })
    }
}

/// Returns the eye's position (w = 1), or the unit direction to it without perspective (w = 0).
fn eye_of(camera: &Camera) -> Vec4 {
    let camera = camera.standard();
    if camera.clip_from_view.row(3) == Vec4::W {
        return Vec3::from(camera.world_from_view.matrix3.z_axis)
            .normalize_or_zero()
            .extend(0.0);
    }
    camera.eye().extend(1.0)
}

/// Returns the unit vector against a spot's axis, and the [`cone`]'s outer cosine and scale. For
/// other lights, the cone contains all directions.
fn cone_of(light: &Light) -> (Vec3, Vec2) {
    let (direction, inner, outer) = match *light {
        Light::Spot {
            direction,
            inner,
            outer,
            ..
        } => (direction, inner, outer),
        Light::Directional { .. }
        | Light::Point { .. }
        | Light::Rect { .. }
        | Light::Disc { .. } => return (Vec3::ZERO, Vec2::new(-1.0, 1.0)),
    };
    let inner_cosine = f64::from(inner).cos();
    let outer_cosine = f64::from(outer).cos();
    // Use a huge but finite scale for a sharp edge, so that zero times it stays zero.
    let scale = (1.0 / (inner_cosine - outer_cosine).max(1e-9)) as f32;
    let axis = -direction.as_dvec3().normalize_or_zero().as_vec3();
    (axis, Vec2::new(outer_cosine as f32, scale))
}

/// Shading of one view of one scene, which can be added to any technique's recipe. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Shading {
    settings: BlinnPhong,
    kernel: BlinnPhongKernel,
}

impl Shading {
    /// Returns the recipe with a colour image on top. Backends then return it as
    /// [`Shadows::picture`](umbrage_core::Shadows::picture). Any earlier shading of the recipe is
    /// replaced.
    #[must_use]
    pub fn add_to(&self, mut recipe: Recipe) -> Recipe {
        let first = recipe.tables.len();
        recipe.tables.extend(self.kernel.tables.tables());
        let background = self.settings.background.extend(1.0).to_array();
        let tables = (first..recipe.tables.len()).collect();
        recipe.shade = Some(Shade {
            kernel: Arc::new(self.kernel.clone()),
            tables,
            background,
        });
        recipe
    }

    /// Returns the shading of the same scene with another camera or light. Tables are shared, so
    /// backends need not upload them again.
    ///
    /// # Errors
    /// Errors if the camera or the light is invalid.
    pub fn with_view(&self, view: &View<'_>) -> Result<Self, Invalid> {
        let uniforms = self.settings.uniforms(view)?;
        Ok(Self {
            kernel: BlinnPhongKernel {
                uniforms,
                ..self.kernel.clone()
            },
            ..*self
        })
    }
}

uniforms! {
    /// Uniforms of [`BlinnPhongKernel`].
    pub struct BlinnPhongUniforms {
        /// Eye position (w = 1), or the unit direction to the eye (w = 0).
        pub eye: Vec4,
        /// Centre of the light (w = 1), or the unit direction to the light (w = 0).
        pub light: Vec4,
        /// Unit vector against a spot's axis; zero for other lights.
        pub axis: Vec4,
        /// Colour of the light times its intensity.
        pub color: Vec4,
        /// Ambient light.
        pub ambient: Vec4,
        /// Constant, linear and quadratic factors.
        pub attenuation: Vec4,
        /// Cosine of the outer angle (x); 1 over the inner angle's cosine minus the outer one's
        /// (y).
        pub cone: Vec2,
    }
}

/// Blinn-Phong kernel.
#[derive(Clone, Debug)]
pub struct BlinnPhongKernel {
    uniforms: BlinnPhongUniforms,
    tables: SurfaceTables,
}

impl Kernel for BlinnPhongKernel {
    fn modules(&self) -> Vec<Module> {
        let own = module!("blinn_phong");
        vec![TEXTURE, INTERPOLATION, SURFACE, LIGHTING, own]
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ShadeKernel for BlinnPhongKernel {
    fn shade(&self, span: &Span<'_>, visibility: &[f32], out: &mut [[f32; 4]]) {
        for (i, (out, &visibility)) in out.iter_mut().zip(visibility).enumerate() {
            if let Some(color) = self.color(
                span.triangle[i],
                span.position(i),
                span.normal(i),
                visibility,
            ) {
                *out = color.extend(1.0).to_array();
            }
        }
    }
}

/// Returns the vector from `p` to a point (w = 1), or a direction (w = 0).
#[inline(always)]
fn direction_towards(to: Vec4, p: Vec3) -> Vec3 {
    Vec3::new(to.x - p.x * to.w, to.y - p.y * to.w, to.z - p.z * to.w)
}

impl BlinnPhongKernel {
    /// Returns the linear colour of a visible point; `None` if there is no such triangle.
    #[inline(always)]
    fn color(&self, triangle: u32, p: Vec3, n: Vec3, visibility: f32) -> Option<Vec3> {
        let u = &self.uniforms;
        let s = self.tables.surface(triangle, p, n)?;
        let l = unit_or(direction_towards(u.light, p), Vec3::ZERO);
        let v = unit_or(direction_towards(u.eye, p), Vec3::ZERO);
        let lit = self.arriving_light(p, n, l, visibility);
        let share = blinn(s.normal, l, v, s.shininess_log2);
        let reflected = s.diffuse * share.x + s.specular * share.y;
        Some(s.emissive + u.ambient.truncate() * s.diffuse + lit * reflected)
    }

    /// Returns the linear light that arrives at a point whose geometric normal is `n`. `l` is the
    /// unit direction to the light.
    #[inline(always)]
    fn arriving_light(&self, p: Vec3, n: Vec3, l: Vec3, visibility: f32) -> Vec3 {
        if dot3(n, l) <= 0.0 {
            return Vec3::ZERO;
        }
        let u = &self.uniforms;
        let to_light = direction_towards(u.light, p);
        let distance = dot3(to_light, to_light).sqrt();
        let share = cone(dot3(u.axis.truncate(), l), u.cone.x, u.cone.y);
        u.color.truncate() * (visibility * share * attenuation(u.attenuation.truncate(), distance))
    }
}

#[cfg(test)]
#[path = "blinn_phong_tests.rs"]
mod tests;
