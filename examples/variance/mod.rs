//! Variance shadow maps, written as a user of the library would: Donnelly and Lauritzen 2006, "Variance shadow maps".
//! Depth and its square are averaged over a square of texels; Chebyshev's inequality bounds the share of it that is
//! farther than the receiver. Bleeds light where casters overlap in depth.

use std::sync::Arc;
use umbrage::{
    Cast, Filter, FilterKernel, Format, ImageDesc, Inputs, Kernel, Layout, Module, PlanError,
    Receive, ReceiveKernel, Recipe, ShadowTechnique, Span, UniformLayout, Uniforms, View,
    glam::{IVec2, UVec2},
    techniques::{
        ShadowMap,
        shadow_map::{coord::shadow_coord, layers::ShadowMapUniforms},
    },
    uniforms,
};

/// The technique: its parameters are its fields.
#[derive(Clone, Copy, Debug)]
pub struct Variance {
    /// The depth map behind the moments.
    pub map: ShadowMap,
    /// Blur radius, texels.
    pub radius: u32,
    /// Least variance, squared clip depth: hides rounding.
    pub least_variance: f32,
}

impl ShadowTechnique for Variance {
    fn name(&self) -> &'static str {
        "variance"
    }

    fn settings(&self) -> String {
        format!("blur {}, {}", self.radius, self.map.label())
    }

    /// The one texel that is looked up holds what the blur took from around it.
    fn kernel_reach(&self) -> Option<f32> {
        Some(self.radius as f32)
    }

    fn plan(&self, view: &View<'_>) -> Result<Recipe, PlanError> {
        // One map: the filters below would do for six as well.
        let map = ShadowMap {
            layout: Layout::Single,
            ..self.map
        };
        let spaces = map.spaces(view, self.radius as f32)?;
        let image = |label, format| ImageDesc {
            label,
            size: UVec2::splat(self.map.size),
            layers: 1,
            format,
        };
        let blur = |x, y| {
            Blur(BlurUniforms {
                step: IVec2::new(x, y),
                radius: self.radius as i32,
                size: self.map.size as i32,
            })
        };
        let filter = |kernel: Arc<dyn FilterKernel>, input, output| Filter {
            kernel,
            inputs: vec![input],
            tables: Vec::new(),
            output,
        };
        let lookup = ShadowMapUniforms::new(&map, view, &spaces);
        let receive = Chebyshev(ChebyshevUniforms {
            lookup,
            least_variance: self.least_variance,
        });
        Ok(Recipe {
            images: vec![
                image("depth", Format::Depth32),
                image("moments", Format::Rg32),
                image("blurred once", Format::Rg32),
            ],
            tables: Vec::new(),
            casts: vec![Cast {
                cull: self.map.bias.cull,
                bias: self.map.bias.raster,
                ..Cast::nearest(0, 0, spaces.spaces[0])
            }],
            filters: vec![
                filter(Arc::new(Moments), 0, 1),
                filter(Arc::new(blur(1, 0)), 1, 2),
                filter(Arc::new(blur(0, 1)), 2, 1),
            ],
            receive: Receive {
                kernel: Arc::new(receive),
                inputs: vec![1],
                tables: Vec::new(),
            },
            shade: None,
            keep_images: false,
        })
    }
}

uniforms! {
    /// Shaders want something bound.
    pub struct NoUniforms {
        /// Not read.
        pub unused: f32,
    }
}

/// Depth to depth and its square.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments;

impl Kernel for Moments {
    fn modules(&self) -> Vec<Module> {
        vec![Module {
            name: "moments",
            text: include_str!("moments.wgsl"),
        }]
    }

    fn uniform_bytes(&self) -> Vec<u8> {
        NoUniforms { unused: 0.0 }.to_bytes()
    }

    fn layout(&self) -> UniformLayout {
        NoUniforms::layout()
    }
}

impl FilterKernel for Moments {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        for (x, texel) in out.chunks_exact_mut(2).enumerate() {
            let depth = inputs.images[0].load(start.x as i32 + x as i32, start.y as i32, layer);
            texel.copy_from_slice(&[depth, depth * depth]);
        }
    }
}

uniforms! {
    /// Uniforms of [`Blur`].
    pub struct BlurUniforms {
        /// (1, 0) along rows, (0, 1) along columns.
        pub step: IVec2,
        /// Texels to each side.
        pub radius: i32,
        /// Side of the image, texels.
        pub size: i32,
    }
}

/// The mean along a row or a column, edges repeated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blur(BlurUniforms);

impl Kernel for Blur {
    fn modules(&self) -> Vec<Module> {
        vec![Module {
            name: "blur",
            text: include_str!("blur.wgsl"),
        }]
    }

    fn uniform_bytes(&self) -> Vec<u8> {
        self.0.to_bytes()
    }

    fn layout(&self) -> UniformLayout {
        BlurUniforms::layout()
    }
}

impl FilterKernel for Blur {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let (u, image) = (self.0, inputs.images[0]);
        let side = (2 * u.radius + 1) as f32;
        for (x, texel) in out.chunks_exact_mut(2).enumerate() {
            let mut sum = [0.0, 0.0];
            for i in -u.radius..=u.radius {
                let at = start.as_ivec2() + IVec2::new(x as i32, 0) + u.step * i;
                let at = at.clamp(IVec2::ZERO, IVec2::splat(u.size - 1));
                let first = image.index(at.x, at.y, layer);
                sum = [
                    sum[0] + image.texels[first],
                    sum[1] + image.texels[first + 1],
                ];
            }
            texel.copy_from_slice(&[sum[0] / side, sum[1] / side]);
        }
    }
}

uniforms! {
    /// Uniforms of [`Chebyshev`].
    pub struct ChebyshevUniforms {
        /// The way to the map.
        pub lookup: ShadowMapUniforms,
        /// Least variance, squared clip depth.
        pub least_variance: f32,
    }
}

/// The bound on the lit share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chebyshev(ChebyshevUniforms);

impl Kernel for Chebyshev {
    fn modules(&self) -> Vec<Module> {
        self.0
            .lookup
            .modules()
            .into_iter()
            .chain([Module {
                name: "chebyshev",
                text: include_str!("receive.wgsl"),
            }])
            .collect()
    }

    fn uniform_bytes(&self) -> Vec<u8> {
        self.0.to_bytes()
    }

    fn layout(&self) -> UniformLayout {
        ChebyshevUniforms::layout()
    }
}

impl ReceiveKernel for Chebyshev {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let (u, image) = (&self.0, inputs.images[0]);
        for (i, out) in out.iter_mut().enumerate() {
            let l = shadow_coord(&u.lookup, span.position(i), span.normal(i));
            let (x, y, size) = (
                l.texel.x.floor() as i32,
                l.texel.y.floor() as i32,
                u.lookup.size as i32,
            );
            if !l.seen || x < 0 || y < 0 || x >= size || y >= size {
                *out = 1.0;
                continue;
            }
            let first = image.index(x, y, 0);
            let (mean, square) = (image.texels[first], image.texels[first + 1]);
            let variance = (square - mean * mean).max(u.least_variance);
            let d = l.depth - mean;
            *out = if l.depth <= mean {
                1.0
            } else {
                variance / (variance + d * d)
            };
        }
    }
}
