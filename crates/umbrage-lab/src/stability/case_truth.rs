//! Reference data of a case: truth, and the mask of a perfect map.

use super::texels::{MapTexels, last_point_inside, point_at, to_center};
use crate::error::LabError;
use glam::{DVec2, Vec3};
use umbrage_core::{
    Camera, Fit, Geometry, Invalid, Layout, Light, RecipeError, Scene, View,
    metrics::{Pixel, edges, pixels_near},
};
use umbrage_cpu::Cpu;
use umbrage_plan::truth::{self, Truth, TruthOptions};

/// Distance from true shadow edges, texels, beyond which a pixel is *open*: the reach of the widest
/// compared kernel (7x7) and half a texel of aliasing.
pub const OPEN_TEXELS: f64 = 4.0;

/// Truth of a view, and the mask of a perfect map of a given size.
#[derive(Clone, Debug)]
pub struct CaseTruth {
    /// The scene.
    pub scene: Scene,
    /// Triangles of the scene.
    pub geometry: Geometry,
    /// The camera.
    pub camera: Camera,
    /// The lights; masks are means over them.
    pub lights: Vec<Light>,
    /// Truth; its visibility is the mean over all lights.
    pub truth: Truth,
    /// Mask of a perfect map: truth at the centre of each receiver's texel.
    pub ideal: Vec<f32>,
    /// Truth with each light reduced to a point at its centre.
    pub hard: Vec<f32>,
    /// Counted pixels farther than [`OPEN_TEXELS`] from any shadow edge.
    pub open: Vec<bool>,
    /// Side of the maps, texels.
    pub map_size: u32,
}

impl CaseTruth {
    /// Traces truth under each light and averages it over the lights.
    ///
    /// # Errors
    /// Errors if the scene has no light or camera, or contains unusable numbers.
    pub fn new(
        scene: Scene,
        camera: Camera,
        lights: Vec<Light>,
        map_size: u32,
        options: &TruthOptions,
    ) -> Result<Self, LabError> {
        let geometry = Geometry::bake(&scene)?;
        let mut cpu = Cpu::new();
        let mut by_light = Vec::new();
        for light in &lights {
            by_light.push(LightTruth::new(
                &camera, light, &geometry, map_size, options, &mut cpu,
            )?);
        }
        let merged = by_light.into_iter().reduce(LightTruth::merged_with);
        let Some(sums) = merged else {
            let what = format!("scene `{}`", scene.name);
            return Err(Invalid::new(what, "has no light", "add one").into());
        };
        let truth = Truth {
            visibility: divide_sums(&sums.truth.visibility, sums.lights),
            ..sums.truth
        };
        Ok(Self {
            scene,
            geometry,
            camera,
            lights,
            truth,
            ideal: divide_sums(&sums.ideal, sums.lights),
            hard: divide_sums(&sums.hard, sums.lights),
            open: sums.open,
            map_size,
        })
    }

    /// Returns the view of the camera under one of the lights.
    pub fn view<'a>(&'a self, light: &'a Light) -> View<'a> {
        View::new(&self.camera, light, &self.geometry)
    }

    /// Reports whether a pixel counts.
    pub fn counts(&self, i: usize) -> bool {
        self.truth.pixels[i] == Pixel::Counted
    }

    /// Returns the indices of the pixels that count.
    pub fn counted_pixels(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.truth.pixels.len()).filter(|&i| self.counts(i))
    }
}

/// Data of [`CaseTruth`] under one light, or sums of visibilities under several.
struct LightTruth {
    truth: Truth,
    ideal: Vec<f32>,
    hard: Vec<f32>,
    open: Vec<bool>,
    /// Number of summed lights.
    lights: f32,
}

impl LightTruth {
    fn new(
        camera: &Camera,
        light: &Light,
        geometry: &Geometry,
        map_size: u32,
        options: &TruthOptions,
        cpu: &mut Cpu,
    ) -> Result<Self, LabError> {
        let truth = truth::trace(
            camera,
            light,
            geometry,
            options,
            &mut |camera, geometry| cpu.receivers(camera, geometry),
            &|_, _| {},
        )?;
        let view = View::new(camera, light, geometry).with_receivers(&truth.receivers);
        let texels = match Fit::Tight.light_spaces(Layout::Auto, &view, map_size, 0.0) {
            Ok(spaces) => Some(MapTexels::new(&spaces, map_size)),
            Err(RecipeError::Unsupported(_)) => None,
            Err(e) => return Err(e.into()),
        };
        let center = without_extent(light);
        let hard = visibility_at_receivers(geometry, &center, &truth, options)?;
        let ideal = match &texels {
            Some(texels) => ideal(texels, camera, light, geometry, &truth, options)?,
            None => truth.visibility.clone(),
        };
        let open = open(texels.as_ref(), &center, geometry, &truth, &hard, options)?;
        Ok(Self {
            truth,
            ideal,
            hard,
            open,
            lights: 1.0,
        })
    }

    /// Adds visibilities. A pixel counts, or is open, only if it does under both lights.
    fn merged_with(mut self, other: Self) -> Self {
        add(&mut self.truth.visibility, &other.truth.visibility);
        add(&mut self.ideal, &other.ideal);
        add(&mut self.hard, &other.hard);
        for i in 0..self.open.len() {
            self.open[i] &= other.open[i];
            if self.truth.pixels[i] == Pixel::Counted {
                self.truth.pixels[i] = other.truth.pixels[i];
            }
        }
        Self {
            lights: self.lights + other.lights,
            ..self
        }
    }
}

fn add(sums: &mut [f32], values: &[f32]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += value;
    }
}

fn divide_sums(sums: &[f32], count: f32) -> Vec<f32> {
    sums.iter().map(|sum| sum / count).collect()
}

/// Returns the light without an extent: a point at its centre, or a direction.
pub fn without_extent(light: &Light) -> Light {
    match *light {
        Light::Directional { direction, .. } => Light::Directional {
            direction,
            angular_diameter: 0.0,
        },
        Light::Point { position, .. } => Light::Point {
            position,
            radius: 0.0,
        },
        Light::Spot {
            position,
            direction,
            inner,
            outer,
            ..
        } => Light::Spot {
            position,
            direction,
            inner,
            outer,
            radius: 0.0,
        },
        Light::Rect { center, .. } | Light::Disc { center, .. } => Light::Point {
            position: center,
            radius: 0.0,
        },
    }
}

/// Traces the visibility of a light at each of truth's receivers; 1 at pixels without a receiver.
pub(super) fn visibility_at_receivers(
    geometry: &Geometry,
    light: &Light,
    truth: &Truth,
    options: &TruthOptions,
) -> Result<Vec<f32>, Invalid> {
    let receivers = &truth.receivers;
    let receiving: Vec<usize> = (0..receivers.len())
        .filter(|&i| receivers.receives[i])
        .collect();
    let any = truth::ReceiverPoint::new(Vec3::ZERO, Vec3::Y, geometry);
    let points: Vec<truth::ReceiverPoint> = receiving
        .iter()
        .map(|&i| point_at(&any, receivers, i, receivers.position(i)))
        .collect();
    let traced = truth::trace_points(geometry, light, &points, options)?;
    let mut out = vec![1.0; receivers.len()];
    for (i, point) in receiving.into_iter().zip(traced) {
        out[i] = point.visibility;
    }
    Ok(out)
}

/// Returns truth at texel centers.
///
/// A texel's center on a receiver's *plane* may be beyond the receiver's triangle and below its
/// neighbor. So the center is moved no farther than the triangle reaches. Its visibility counts
/// only if a true edge is no farther away in the image than the center.
fn ideal(
    texels: &MapTexels,
    camera: &Camera,
    light: &Light,
    geometry: &Geometry,
    truth: &Truth,
    options: &TruthOptions,
) -> Result<Vec<f32>, Invalid> {
    // Move receivers to texel centres within their triangles, and trace there.
    let receivers = &truth.receivers;
    let snapped = texels.seen_texels(
        geometry,
        light,
        receivers,
        options,
        to_center,
        |i, place| {
            let triangle = geometry.corners(receivers.triangle[i]);
            last_point_inside(receivers.position(i), place, triangle)
        },
    )?;
    // Find the pixels near true edges, by distance.
    let edges = edges(truth.size, &truth.visibility, &truth.pixels);
    let is_near_edge = REACHES.map(|reach| pixels_near(truth.size, &edges, reach));
    let clip_from_world = camera.space().clip_from_world();
    let mut out = truth.visibility.clone();
    for (i, moved) in snapped.into_iter().enumerate() {
        let Some((place, traced)) = moved else {
            continue;
        };
        let from = clip_from_world.project_point3(receivers.position(i));
        let to = clip_from_world.project_point3(place);
        // NDC are 2 wide, and the image is `size` pixels wide.
        let from_pixel = from.truncate() * truth.size.as_vec2() * 0.5;
        let to_pixel = to.truncate() * truth.size.as_vec2() * 0.5;
        let distance = to_pixel.distance(from_pixel);
        // Add a pixel, as edges are marked on whole pixels.
        let class = REACHES
            .iter()
            .position(|&reach| distance + 1.0 <= reach as f32)
            .unwrap_or(REACHES.len() - 1);
        if is_near_edge[class][i] {
            out[i] = traced.visibility;
        }
    }
    Ok(out)
}

/// Distances from edges that [`ideal`] distinguishes, pixels.
const REACHES: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];

/// The eight directions in which [`open`] probes around a texel.
const DIRECTIONS: [DVec2; 8] = [
    DVec2::new(1.0, 0.0),
    DVec2::new(1.0, 1.0),
    DVec2::new(0.0, 1.0),
    DVec2::new(-1.0, 1.0),
    DVec2::new(-1.0, 0.0),
    DVec2::new(-1.0, -1.0),
    DVec2::new(0.0, -1.0),
    DVec2::new(1.0, -1.0),
];

/// Marks the open pixels: fully lit or fully dark, with the same visibility at sixteen points
/// around them on the receiver's plane. Eight points are [`OPEN_TEXELS`] away, eight half as far.
///
/// If the ground rises beyond the receiver's triangle, these points are below it and dark. So
/// creases count as edges: errors there show in RMSE and shimmer, not as acne.
fn open(
    texels: Option<&MapTexels>,
    center: &Light,
    geometry: &Geometry,
    truth: &Truth,
    hard: &[f32],
    options: &TruthOptions,
) -> Result<Vec<bool>, Invalid> {
    // Start with pixels that are fully lit or dark.
    let mut open = Vec::with_capacity(hard.len());
    for (i, hard) in hard.iter().enumerate() {
        let visibility = truth.visibility[i];
        let is_counted = truth.pixels[i] == Pixel::Counted;
        let is_full = visibility == 0.0 || visibility == 1.0;
        open.push(is_counted && is_full && visibility == *hard);
    }
    let Some(texels) = texels else {
        return Ok(open);
    };
    // Clear pixels with another visibility around them.
    for reach in [OPEN_TEXELS, 0.5 * OPEN_TEXELS] {
        for direction in DIRECTIONS {
            let offset = direction * reach;
            let around = texels.seen_texels(
                geometry,
                center,
                &truth.receivers,
                options,
                |texel| texel + offset,
                |_, place| place,
            )?;
            for (i, moved) in around.into_iter().enumerate() {
                if let Some((_, traced)) = moved {
                    open[i] &= traced.visibility == hard[i];
                }
            }
        }
    }
    Ok(open)
}
