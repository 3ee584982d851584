//! Tests that the CPU's rasteriser, with the device's rounding of vertices, draws the same as the
//! device.

use glam::{DVec3, Mat4, UVec2, Vec4};
use std::sync::Arc;
use umbrage_core::{
    Backend, Cast, Cull, DepthPlanes, Faces, Format, Geometry, ImageDesc, LightSpace, Recipe,
    Scene, ShadowTechnique, Snapping, Source, View,
};
use umbrage_cpu::{Clipping, Cpu, CpuOptions};
use umbrage_techniques::{Hard, MapTechnique};
use umbrage_tests::gpu::gpu;

const SIDE: usize = 256;
/// Number of triangles in a class, each in a separate layer.
const COUNT: usize = 96;
const CLASSES: [&str; 6] = [
    "wide",
    "small",
    "tiny",
    "perspective",
    "across edges",
    "through the eye",
];

/// Extent of the guard bands of hardware, pixels.
const FARTHEST_GUARD_BAND: f64 = 32_768.0;

/// A small generator of random numbers (Marsaglia: Xorshift RNGs, 2003). The triangles are the same
/// in every run.
struct RasterRandom(u64);

impl RasterRandom {
    fn range(&mut self, lo: f32, hi: f32) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        lo + (hi - lo) * ((self.0 >> 11) as f64 / (1_u64 << 53) as f64) as f32
    }

    /// Returns a random corner in clip space within a square around a point.
    fn corner(&mut self, centre: [f32; 2], radius: f32) -> Vec4 {
        let [x, y] = centre.map(|c| c + self.range(-radius, radius));
        Vec4::new(x, y, self.range(0.05, 0.95), 1.0)
    }

    fn triangle(&mut self, class: &str) -> [Vec4; 3] {
        let middle = [0.0; 2];
        let centre = [self.range(-0.9, 0.9), self.range(-0.9, 0.9)];
        [0; 3].map(|_| match class {
            "wide" => self.corner(middle, 0.99),
            "small" => self.corner(centre, 0.06),
            "tiny" => self.corner(centre, 0.01),
            "perspective" => self.corner(middle, 0.99) * self.range(0.5, 3.0),
            "across edges" => self.corner(middle, 2.0),
            _ => {
                let at = self.corner(middle, 2.0);
                let w = self.range(-1.0, 3.0);
                // A projection whose near and far plane are at 0.1 and 10.
                Vec4::new(at.x, at.y, (w - 0.1) * (10.0 / 9.9), w)
            }
        })
    }
}

/// Draws each triangle into a separate layer.
fn recipe(triangles: &[[Vec4; 3]], view: &View<'_>) -> Recipe {
    let space = LightSpace {
        view_from_world: Mat4::IDENTITY,
        clip_from_view: Mat4::IDENTITY,
    };
    let cast = |(layer, t): (u32, &[Vec4; 3])| {
        let faces = Faces {
            vertices: t.to_vec(),
            triangles: vec![[0, 1, 2]],
        };
        Cast {
            source: Source::Faces(Arc::new(faces)),
            ..Cast::nearest(0, layer, space)
        }
    };
    let layers = triangles.len() as u32;
    let size = UVec2::splat(SIDE as u32);
    let of_hard = MapTechnique::<Hard>::default()
        .recipe(view)
        .expect("hard serves the sun");
    Recipe {
        images: vec![ImageDesc {
            label: "triangles",
            size,
            layers,
            format: Format::Depth32,
        }],
        casts: (0..).zip(triangles).map(cast).collect(),
        hierarchy: None,
        keep_images: true,
        ..of_hard
    }
}

fn cpu(snapping: Snapping) -> Cpu {
    cpu_that_clips(snapping, Clipping::Exact)
}

fn cpu_that_clips(snapping: Snapping, clipping: Clipping) -> Cpu {
    let options = CpuOptions::default().snapping(snapping).clipping(clipping);
    Cpu::with_options(&options).expect("a known rounding")
}

fn layers(backend: &mut dyn Backend, view: &View<'_>, recipe: &Recipe) -> Vec<Vec<f32>> {
    let images = backend.render(view, recipe).expect("renders").images;
    images[0]
        .texels
        .chunks_exact(SIDE * SIDE)
        .map(<[f32]>::to_vec)
        .collect()
}

/// Returns the allowed difference of two drivers' depths of a triangle. Each evaluates the plane
/// through the corners in 32 bits, from an origin of its choice. Over 100,000 random triangles, the
/// measured error of each was below 4 times this sum: 1, plus the plane's changes up to the origin,
/// plus those across the image times the condition of the area (a difference of two products).
/// Changes are per pixel.
fn depth_bound(triangle: &[Vec4; 3]) -> f32 {
    let plane = DepthPlane::new(triangle);
    let across = SIDE as f64 * plane.slope;
    let rounding = 2.0_f64.powi(-24);
    (2.0 * 4.0 * rounding * (1.0 + across + plane.condition * across)) as f32
}

/// Returns the [`depth_bound`] for clipped triangles. Clipping creates corners as far away as the
/// guard band. Their positions are rounded about three times and then to the grid, and they depend
/// on the device. Depths therefore have an additional error of the slope times that, for each of
/// two devices.
fn clipped_depth_bound(snapping: Snapping, triangle: &[Vec4; 3]) -> f32 {
    let corner_error =
        0.5 * f64::from(snapping.step()) + 3.0 * 2.0_f64.powi(-24) * FARTHEST_GUARD_BAND;
    let moved = match snapping.planes {
        DepthPlanes::Snapped => 2.0 * corner_error * DepthPlane::new(triangle).slope,
        DepthPlanes::Unsnapped => 0.0,
    };
    depth_bound(triangle) + moved as f32
}

/// The plane through a triangle's corners.
struct DepthPlane {
    /// Sum of the depth's changes from a pixel to the next along x and y.
    slope: f64,
    /// Condition of the area, a difference of two products: their sizes over its own.
    condition: f64,
}

impl DepthPlane {
    fn new(triangle: &[Vec4; 3]) -> Self {
        let [a, b, c] = triangle.map(|v| {
            let half = 0.5 * SIDE as f64;
            DVec3::new(
                f64::from(v.x / v.w) * half,
                f64::from(v.y / v.w) * half,
                f64::from(v.z / v.w),
            )
        });
        let d = b - a;
        let e = c - a;
        let first = d.x * e.y;
        let second = d.y * e.x;
        let normal = d.cross(e);
        Self {
            slope: (normal.x.abs() + normal.y.abs()) / normal.z.abs(),
            condition: (first.abs() + second.abs()) / (first - second).abs(),
        }
    }
}

/// Differences of a device's layers from the CPU's.
#[derive(Debug, Default)]
struct Differences {
    /// Number of pixels covered by both.
    both: usize,
    /// Number of pixels covered by only one.
    coverage: usize,
    /// Number of pixels whose depths differ by more than the bound.
    depth: usize,
    /// Number of pixels that aren't bit-equal.
    bits: usize,
}

fn compare(triangles: &[[Vec4; 3]], mine: &[Vec<f32>], theirs: &[Vec<f32>]) -> Differences {
    compare_within(triangles, depth_bound, mine, theirs)
}

/// Compares layers. `depth_bound` returns the allowed difference of depths for a triangle.
fn compare_within(
    triangles: &[[Vec4; 3]],
    depth_bound: impl Fn(&[Vec4; 3]) -> f32,
    mine: &[Vec<f32>],
    theirs: &[Vec<f32>],
) -> Differences {
    let mut sum = Differences::default();
    for ((triangle, mine), theirs) in triangles.iter().zip(mine).zip(theirs) {
        let bound = depth_bound(triangle);
        for (a, b) in mine.iter().zip(theirs) {
            let both = *a < 1.0 && *b < 1.0;
            sum.both += usize::from(both);
            sum.coverage += usize::from((*a < 1.0) != (*b < 1.0));
            sum.depth += usize::from(both && (a - b).abs() > bound);
            sum.bits += usize::from(a.to_bits() != b.to_bits());
        }
    }
    sum
}

/// Returns a scene whose camera has few pixels. Recipes here have separate faces and no lookups.
fn small_scene() -> (Scene, Geometry) {
    let entry = umbrage_scenes::find("cubes").expect("a built-in scene");
    let mut scene = (entry.build)();
    scene.cameras[0].size = UVec2::splat(8);
    let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
    (scene, geometry)
}

/// Reports whether triangles of a class extend beyond the image or behind the eye.
fn is_clipped(class: &str) -> bool {
    matches!(class, "across edges" | "through the eye")
}

/// Runs `check` on the triangles, recipe and device's layers of every class.
fn for_each_class(mut check: impl FnMut(&str, &[[Vec4; 3]], &View<'_>, &Recipe, &[Vec<f32>])) {
    let (scene, geometry) = small_scene();
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let mut random = RasterRandom(77);
    for class in CLASSES {
        let triangles: Vec<_> = (0..COUNT).map(|_| random.triangle(class)).collect();
        let recipe = recipe(&triangles, &view);
        let theirs = layers(&mut *gpu(), &view, &recipe);
        check(class, &triangles, &view, &recipe, &theirs);
    }
}

#[test]
fn the_cpu_draws_what_the_device_draws() {
    let (snapping, exact) = {
        let gpu = gpu();
        (gpu.snapping(), gpu.promises_bits())
    };
    println!("{snapping}");
    let mut covered = 0;
    for_each_class(|class, triangles, view, recipe, theirs| {
        // Hardware clips at a guard band, which Vulkan permits.
        let ways: &[Clipping] = if exact {
            &[Clipping::Exact]
        } else {
            &[Clipping::Exact, Clipping::GuardBand]
        };
        let of_way = ways.iter().map(|&clipping| {
            let mine = layers(&mut cpu_that_clips(snapping, clipping), view, recipe);
            if is_clipped(class) {
                let bound = |t: &[Vec4; 3]| clipped_depth_bound(snapping, t);
                compare_within(triangles, bound, &mine, theirs)
            } else {
                compare(triangles, &mine, theirs)
            }
        });
        let differences = of_way
            .min_by_key(|d| d.coverage + d.depth)
            .expect("at least one way");
        println!("{class}: {differences:?}");
        assert_eq!(
            (differences.coverage, differences.depth),
            (0, 0),
            "{class}: {differences:?}"
        );
        assert!(!exact || differences.bits == 0, "{class}: {differences:?}");
        covered += differences.both;
    });
    assert!(covered > 1_000_000, "only {covered} pixels were covered");
}

/// An NVIDIA H200 covered 22 of 933,542 pixels differently from the CPU, all in triangles across
/// the edges of the image. The position of clipping explains them: with a guard band, such
/// triangles keep their corners, and at the edges they have new ones, on the grid.
#[test]
fn a_guard_band_changes_few_pixels_across_edges_and_no_others() {
    let of_h200 = Snapping {
        planes: DepthPlanes::Snapped,
        ..Snapping::default()
    };
    let mut across_edges = 0;
    for_each_class(|class, triangles, view, recipe, _| {
        let [exact, guard_band] = [Clipping::Exact, Clipping::GuardBand]
            .map(|clipping| layers(&mut cpu_that_clips(of_h200, clipping), view, recipe));
        let bound = |t: &[Vec4; 3]| clipped_depth_bound(of_h200, t);
        let differences = compare_within(triangles, bound, &exact, &guard_band);
        println!("{class}: {differences:?}");
        match class {
            "across edges" => across_edges = differences.coverage,
            "through the eye" => {}
            _ => assert_eq!(differences.coverage, 0, "{class}"),
        }
        assert_eq!(differences.depth, 0, "{class}");
    });
    assert_eq!(across_edges, 22, "as many as on the H200");
}

/// Negative control: every other rounding differs from the device's on the same triangles.
#[test]
fn another_rounding_is_noticed() {
    let snapping = gpu().snapping();
    let planes = [DepthPlanes::Unsnapped, DepthPlanes::Snapped];
    let others = Snapping::BITS.flat_map(|sub_pixel_bits| {
        planes.map(|planes| Snapping {
            sub_pixel_bits,
            planes,
            ..snapping
        })
    });
    let others: Vec<Snapping> = others.filter(|&other| other != snapping).collect();
    for_each_class(|class, triangles, view, recipe, theirs| {
        if class != "small" {
            return;
        }
        for &other in &others {
            let differences = compare(triangles, &layers(&mut cpu(other), view, recipe), theirs);
            let moved = other.sub_pixel_bits == snapping.sub_pixel_bits || differences.coverage > 0;
            let tilted = other.planes == snapping.planes || differences.depth > 0;
            assert!(moved && tilted, "{other}: {differences:?}");
        }
    });
}

/// Returns a triangle thinner than a step of the grid, along a line through a pixel's centre, that
/// extends beyond the window.
fn sliver(random: &mut RasterRandom) -> [Vec4; 3] {
    let pixel = || SIDE as f32 / 2.0;
    let mut centre = || (random.range(-pixel(), pixel()).floor() + 0.5) / pixel();
    let (x, y) = (centre(), centre());
    let angle = random.range(0.0, std::f32::consts::TAU);
    let mut along = |distance: f32| {
        // A step is 1/256 pixel.
        let step = 1.0 / 256.0 / pixel();
        let mut aside = || random.range(-0.5, 0.5) * step;
        Vec4::new(
            x + angle.cos() * distance + aside(),
            y + angle.sin() * distance + aside(),
            0.5,
            1.0,
        )
    };
    // Two corners are outside the window, and one inside. After snapping to the grid, it may be on
    // the other side of the line between them.
    [along(-3.0), along(3.0), along(0.125)]
}

/// Faces are culled by the orientation of slivers after clipping, and again on the grid. Some show
/// neither of their faces; on the CPU they are the same ones.
#[test]
fn slivers_that_are_clipped_are_culled_alike() {
    if !gpu().promises_bits() {
        // Skip other drivers, which clip differently and have arbitrary orientations of slivers.
        return;
    }
    let (scene, geometry) = small_scene();
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let mut random = RasterRandom(5);
    let mut shown_by_neither_face = 0;
    for _ in 0..4 {
        let slivers: Vec<_> = (0..COUNT).map(|_| sliver(&mut random)).collect();
        let [all, front, back] = [Cull::None, Cull::Back, Cull::Front].map(|cull| {
            let mut recipe = recipe(&slivers, &view);
            for cast in &mut recipe.casts {
                cast.cull = cull;
            }
            let theirs = layers(&mut *gpu(), &view, &recipe);
            let mine = layers(&mut Cpu::new(), &view, &recipe);
            let bits = compare(&slivers, &mine, &theirs).bits;
            assert_eq!(bits, 0, "{cull:?}");
            theirs
        });
        for ((all, front), back) in all.iter().zip(&front).zip(&back) {
            let shows = |layer: &[f32]| layer.iter().any(|depth| *depth < 1.0);
            let neither = shows(all) && !shows(front) && !shows(back);
            shown_by_neither_face += u32::from(neither);
        }
    }
    assert!(
        shown_by_neither_face >= 10,
        "only {shown_by_neither_face} slivers change orientation on the grid"
    );
}
