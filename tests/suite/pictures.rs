//! Tests of colour images: Blinn-Phong by both backends, with textures, normal maps, every kind of
//! light, and a marker.
//!
//! The kernel uses no transcendental function and writes out every sum, so linear colours are
//! bit-equal on the pinned software driver. On any other driver, encoded colours are within
//! [`BOUND`] wherever both see the same triangle and the same shadow.

use std::sync::Arc;
use umbrage_core::{
    Backend as _, Geometry, Kernel, Module, Recipe, ShadeKernel, ShadowTechnique, Shadows, Span,
    UniformBlock, Uniforms as _, View, join, picture,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::{
    Bias, BlinnPhong, BlinnPhongUniforms, Hard, MapFilter as _, ShadowMap, Traced,
};
use umbrage_tests::{gpu::gpu, layouts, painted};

/// One step of an 8-bit image: two encoders may round a value between two bytes either way.
const BOUND: u8 = 1;

/// Results of both backends, and whether the driver is the pinned one.
struct PicturePair {
    cpu: Shadows,
    gpu: Shadows,
    exact: bool,
}

fn render(view: &View<'_>, recipe: &Recipe) -> PicturePair {
    let cpu = Cpu::new().render(view, recipe).expect("the CPU renders it");
    let mut gpu = gpu();
    let exact = gpu.promises_bits();
    PicturePair {
        cpu,
        gpu: gpu.render(view, recipe).expect("the GPU renders it"),
        exact,
    }
}

/// Returns a message about the differences of the images. `None` if they are allowed.
fn fault(pair: &PicturePair) -> Option<String> {
    let pictures = [&pair.cpu, &pair.gpu].map(|s| s.picture.as_deref());
    let [Some(cpu), Some(gpu)] = pictures else {
        return Some("a picture is missing".to_owned());
    };
    if cpu.len() != gpu.len() {
        return Some(format!("{} and {} pixels", cpu.len(), gpu.len()));
    }
    let mut wrong = Vec::new();
    for i in 0..cpu.len() {
        let differs = if pair.exact {
            cpu[i].map(f32::to_bits) != gpu[i].map(f32::to_bits)
        } else {
            differ_visibly(cpu[i], gpu[i]) && same_seen(pair, i)
        };
        if differs {
            wrong.push(i);
        }
    }
    let &first = wrong.first()?;
    Some(format!(
        "{} pixels differ; first {first}: {:?} and {:?}",
        wrong.len(),
        cpu[first],
        gpu[first]
    ))
}

/// Reports whether two colours, as bytes of sRGB, differ by more than [`BOUND`].
fn differ_visibly(a: [f32; 4], b: [f32; 4]) -> bool {
    (0..3).any(|k| picture::encode(a[k]).abs_diff(picture::encode(b[k])) > BOUND)
}

/// Reports whether both backends see the same triangle with the same shadow on it.
fn same_seen(pair: &PicturePair, i: usize) -> bool {
    let triangle = |s: &Shadows| s.receivers.as_ref().map(|r| r.triangle[i]);
    triangle(&pair.cpu) == triangle(&pair.gpu) && pair.cpu.mask[i] == pair.gpu.mask[i]
}

/// Calls `check` with a name, the view and a shading recipe, for every light, camera and technique.
fn each_case(mut check: impl FnMut(&str, &View<'_>, &Recipe)) {
    let map = ShadowMap {
        size: 256,
        bias: Bias::SLOPE,
        ..ShadowMap::default()
    };
    let techniques: [Arc<dyn ShadowTechnique>; 2] =
        [Arc::new(Hard {}.on(map)), Arc::new(Traced { samples: 4 })];
    for light in painted::lights() {
        for (c, camera) in painted::cameras()
            .expect("good cameras")
            .into_iter()
            .enumerate()
        {
            let scene = painted::scene(light, camera).expect("a good scene");
            let geometry = Geometry::bake(&scene).expect("a good scene");
            let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
            let shading = BlinnPhong::default()
                .shading(&scene, &view)
                .expect("it shades");
            for technique in &techniques {
                let recipe = technique.recipe(&view).expect("it plans");
                check(
                    &format!("{}, camera {c}, {}", light.kind(), technique.name()),
                    &view,
                    &shading.add_to(recipe),
                );
            }
        }
    }
}

#[test]
fn both_backends_paint_the_same_picture() {
    let mut faults = Vec::new();
    each_case(|name, view, recipe| {
        let pair = render(view, recipe);
        faults.extend(fault(&pair).map(|why| format!("{name}: {why}")));
        proves_something(name, &pair.cpu);
    });
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Checks that shadow, light, highlights, the marker, the background and many colours are all in
/// the image.
fn proves_something(name: &str, shadows: &Shadows) {
    let picture = shadows.picture.as_deref().unwrap_or_default();
    let count = |what: &dyn Fn(usize, [f32; 4]) -> bool| {
        (0..picture.len()).filter(|&i| what(i, picture[i])).count()
    };
    let background = BlinnPhong::default().background.extend(1.0).to_array();
    assert!(
        count(&|i, _| shadows.mask[i] == 0.0) > 100,
        "{name}: hardly a shadow"
    );
    assert!(
        count(&|_, p| p == background) > 100,
        "{name}: hardly a background"
    );
    assert!(count(&|_, p| p == [1.0; 4]) > 4, "{name}: no marker");
    let mut colors: Vec<_> = picture.iter().map(|p| p.map(picture::encode)).collect();
    colors.sort_unstable();
    colors.dedup();
    assert!(colors.len() > 1000, "{name}: only {} colours", colors.len());
}

/// The kernel with a mutated WGSL half.
#[derive(Debug)]
struct Spoilt {
    kernel: Arc<dyn ShadeKernel>,
    from: &'static str,
    to: &'static str,
}

impl Kernel for Spoilt {
    fn modules(&self) -> Vec<Module> {
        let spoil = |m: Module| Module {
            text: m.text.replace(self.from, self.to).leak(),
            ..m
        };
        self.kernel.modules().into_iter().map(spoil).collect()
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        self.kernel.uniforms()
    }
}

impl ShadeKernel for Spoilt {
    fn shade(&self, span: &Span<'_>, visibility: &[f32], out: &mut [[f32; 4]]) {
        self.kernel.shade(span, visibility, out);
    }
}

#[test]
fn uniforms_lie_where_the_shader_reads_them() {
    let mut checked = 0;
    each_case(|_, _, recipe| {
        let kernel = recipe
            .shade
            .as_ref()
            .map(|shade| &shade.kernel)
            .expect("it shades");
        layouts::check(&BlinnPhongUniforms::layout(), &join(&kernel.modules()))
            .expect("same layout");
        let uniforms = kernel.uniforms().expect("it has some");
        assert!(
            uniforms.uniform_bytes().len() as u64 >= uniforms.uniform_layout().size,
            "too few bytes"
        );
        checked += 1;
    });
    assert_eq!(checked, 20);
}

/// Mutations of the shader, each of which must be detected in the image.
const SLIPS: [(&str, &str); 6] = [
    ("l + v", "l - v"),
    ("color * bilinear", "color + bilinear"),
    ("texel.y * 2.0 - 1.0", "1.0 - texel.y * 2.0"),
    ("3u * triangle.x + row", "3u * triangle.y + row"),
    ("visibility * share", "share"),
    ("uv.y, texture.z", "uv.x, texture.z"),
];

/// Reports whether both comparisons fail.
fn is_caught(pair: &mut PicturePair) -> bool {
    [true, false].into_iter().all(|exact| {
        pair.exact = exact;
        fault(pair).is_some()
    })
}

#[test]
fn spoilt_pixels_and_spoilt_shaders_are_caught() {
    let mut cases = 0;
    each_case(|name, view, recipe| {
        cases += 1;
        // Test a single case.
        if cases == 1 {
            spoil_pixel(render(view, recipe));
            SLIPS.iter().for_each(|slip| {
                assert!(
                    is_caught(&mut spoil_shader(view, recipe, *slip)),
                    "{name}: {slip:?}"
                )
            });
        }
    });
    assert_eq!(cases, 20);
}

fn spoil_pixel(mut pair: PicturePair) {
    assert_eq!(fault(&pair), None);
    let picture = pair.gpu.picture.as_mut().expect("a picture");
    let grey = picture
        .iter()
        .position(|c| c[1] > 0.2 && c[1] < 0.3)
        .expect("a pixel between black and white");
    picture[grey][1] += 0.02;
    assert!(is_caught(&mut pair));
}

fn spoil_shader(
    view: &View<'_>,
    recipe: &Recipe,
    slip: (&'static str, &'static str),
) -> PicturePair {
    let (from, to) = slip;
    let mut recipe = recipe.clone();
    let shade = recipe.shade.as_mut().expect("it shades");
    assert!(
        shade.kernel.modules().iter().any(|m| m.text.contains(from)),
        "nothing to spoil: {from}"
    );
    shade.kernel = Arc::new(Spoilt {
        kernel: shade.kernel.clone(),
        from,
        to,
    });
    render(view, &recipe)
}
