//! A frame: casters, receivers and a light in buffers, and the answers of the library's rays.

use crate::device::Device;
use anyhow::{Context as _, Result, ensure};
use std::time::Duration;
use umbrage::{
    Aabb, Backend as _, Geometry, Module, Receivers, Recipe, ShadowTechnique as _, View,
    bvh::segment_hits,
    cpu::Cpu,
    glam::{UVec2, Vec2, Vec3},
    gpu::{AdapterChoice, Gpu, wgpu::Buffer},
    join,
    light_sample::{LightSampler, ray_origin, segment},
    scenes,
    techniques::{Exact, Hard, MapFilter as _, ShadowMap, Traced},
};

/// Number of receivers that are tested with all casters to find those to leave out.
const SAMPLED: usize = 64;

/// A scene under its first light, seen by its first camera.
pub(crate) struct Frame {
    pub(crate) name: String,
    pub(crate) size: UVec2,
    pub(crate) casters: u32,
    /// True if the light has a position.
    pub(crate) is_lamp: bool,
    /// Three rows a caster: corners; w of the second row is the record of its alpha test.
    pub(crate) corners: Buffer,
    /// Two rows a pixel: position and triangle id, normal and whether there is a receiver.
    pub(crate) receivers: Buffer,
    /// Alpha textures of casters.
    pub(crate) cut_outs: Buffer,
    /// `ExactUniforms` of the library.
    pub(crate) kernel: Buffer,
    /// Names and offsets of its fields.
    kernel_fields: Vec<(&'static str, u64)>,
    /// `ListsGrid` of the library, with the margins that a device uses.
    pub(crate) grid: Vec<u32>,
    /// Bounds of the casters; the eighth float is the error of the triangle test, metres.
    pub(crate) world: [f32; 8],
    /// Modules of the library that build lists on a device.
    pub(crate) list_modules: Vec<Module>,
    /// Modules of the library's `exact` kernel.
    modules: Vec<Module>,
    /// The library's rays.
    pub(crate) rays: Recipe,
    /// Visibility of each pixel's light by the library's rays.
    pub(crate) expected: Vec<u32>,
    /// True for pixels with a receiver that faces the light.
    pub(crate) faces_light: Vec<bool>,
    /// Times of a hard map's cast and lookup on the library's own device.
    pub(crate) hard: [Duration; 2],
}

impl Frame {
    /// Loads a scene, and traces the expected answers on the CPU. If it `is_spoilt`, the
    /// device does not get the casters that hide a receiver, to test the comparison.
    pub(crate) fn load(device: &Device, name: &str, size: UVec2, is_spoilt: bool) -> Result<Self> {
        let scene = scenes::by_argument(name)?;
        let geometry = Geometry::bake(&scene)?;
        let camera = scene.cameras[0].with_size(size);
        let light = scene.lights.first().context("the scene has no light")?;
        let light = light.without_extent();
        let mut cpu = Cpu::new();
        let receivers = cpu.receivers(&camera, &geometry)?;
        let view = View::new(&camera, &light, &geometry).with_receivers(&receivers);
        let rays = Traced { samples: 1 }.recipe(&view)?;
        let expected = cpu.render(&view, &rays)?.mask;
        let hard = hard_times(&view)?;
        let exact = Exact::default().recipe(&view)?;
        let uniforms = exact.receive.kernel.uniforms();
        let uniforms = uniforms.context("`exact` has no uniforms")?;
        let kernel_fields = uniforms.uniform_layout().fields;
        let mut kernel: Vec<u32> = bytemuck::pod_collect_to_vec(&uniforms.uniform_bytes());
        let on_device = Exact::default().device_recipe(&view);
        let on_device = on_device.context("`exact` has no device recipe")??;
        let mut grid: Vec<u32> = bytemuck::pod_collect_to_vec(&on_device.lists.uniforms);
        if light.position().is_none() {
            turn_upright(&kernel_fields, &mut kernel, &mut grid)?;
        }

        let casters = geometry.casters();
        ensure!(casters.start == 0, "casters are not the first triangles");
        let mut corners: Vec<[f32; 4]> = Vec::new();
        for id in casters.clone() {
            let record = geometry.cut_outs().and_then(|c| c.record_row(id));
            let [a, b, c] = geometry.corners(id);
            corners.push(a.extend(0.0).to_array());
            corners.push(b.extend(f32::from_bits(record.unwrap_or(0))).to_array());
            corners.push(c.extend(0.0).to_array());
        }
        if is_spoilt {
            let ids = fewest_blockers(&view, &geometry, &receivers, &expected);
            ensure!(!ids.is_empty(), "no receiver is in shadow");
            // Replace them by casters without area at a far corner.
            let far = geometry.bounds().max.to_array();
            for row in ids.into_iter().flat_map(|id| 3 * id..3 * id + 3) {
                corners[row][..3].copy_from_slice(&far);
            }
        }
        let mut rows: Vec<[f32; 4]> = Vec::new();
        let mut faces_light = Vec::new();
        for i in 0..receivers.len() {
            let receives = receivers.receives[i];
            let (p, n) = (receivers.position(i), receivers.normal(i));
            rows.push(p.extend(f32::from_bits(receivers.triangle[i])).to_array());
            rows.push(n.extend(f32::from(u8::from(receives))).to_array());
            faces_light.push(receives && n.dot(light.direction_from(p)) > 0.0);
        }
        let bounds = geometry.caster_bounds();
        let around = Aabb::from_points([camera.eye()]).union(&geometry.bounds());
        let mut world = [0.0; 8];
        world[..3].copy_from_slice(&bounds.min.to_array());
        world[4..7].copy_from_slice(&bounds.max.to_array());
        // Four times the bound of the library's ray_triangle.rs.
        world[7] = around.diagonal() / 524_288.0;
        let no_rows: [[u32; 4]; 1] = [[0; 4]];
        let cut_outs = geometry.cut_outs().map(|c| c.rows().clone());
        let cut_outs = cut_outs.as_deref().unwrap_or(&no_rows);
        Ok(Self {
            name: name.to_owned(),
            size,
            casters: casters.len() as u32,
            is_lamp: light.position().is_some(),
            corners: device.storage("corners", bytemuck::cast_slice(&corners)),
            receivers: device.storage("receivers", bytemuck::cast_slice(&rows)),
            cut_outs: device.storage("cut-outs", bytemuck::cast_slice(cut_outs)),
            kernel: device.uniform("kernel", bytemuck::cast_slice(&kernel)),
            world,
            kernel_fields,
            list_modules: on_device.lists.modules,
            grid,
            modules: exact.receive.kernel.modules(),
            rays,
            expected: expected.iter().map(|v| v.to_bits()).collect(),
            faces_light,
            hard,
        })
    }

    /// Returns the library's WGSL for a ray and a caster, with `ExactUniforms` and `frame_point`,
    /// without the lookup of lists.
    pub(crate) fn ray_wgsl(&self) -> Result<String> {
        let mut text = join(&[umbrage::MATH]);
        for module in &self.modules {
            match module.name {
                "item_key" => {}
                "exact" => {
                    let (before, _) = module
                        .text
                        .split_once("fn is_shadowed")
                        .context("exact.wgsl has no `is_shadowed`")?;
                    text += before;
                }
                _ => text += module.text,
            }
            text += "\n";
        }
        Ok(text)
    }

    /// Returns the WGSL of `ExactUniforms`.
    pub(crate) fn uniforms_wgsl(&self) -> Result<&'static str> {
        let exact = self.modules.iter().find(|module| module.name == "exact");
        let text = exact.context("no module `exact`")?.text;
        let (before, _) = text
            .split_once("// Greatest number below 1.")
            .context("exact.wgsl has changed")?;
        Ok(before)
    }

    /// Returns the WGSL of the library's lookup of lists.
    pub(crate) fn lists_wgsl(&self) -> String {
        join(&[umbrage::MATH]) + &join(&self.modules)
    }

    /// Returns the word at which a field of `kernel` begins.
    pub(crate) fn kernel_offset(&self, name: &str) -> Result<usize> {
        word_of(&self.kernel_fields, name)
    }

    /// Returns a module of the library that builds lists on a device.
    pub(crate) fn module(&self, name: &str) -> Result<Module> {
        let mut modules = self.list_modules.iter();
        let module = modules.find(|module| module.name == name);
        module
            .copied()
            .with_context(|| format!("no module `{name}`"))
    }

    /// Returns the number of pixels.
    pub(crate) fn pixels(&self) -> u32 {
        self.size.x * self.size.y
    }
}

/// Returns the least times of a hard map's cast and lookup.
fn hard_times(view: &View<'_>) -> Result<[Duration; 2]> {
    let map = ShadowMap {
        size: 2048,
        ..ShadowMap::default()
    };
    let recipe = Hard {}.on(map).recipe(view)?;
    let mut gpu = Gpu::new(&AdapterChoice::from_env())?;
    let mut least = [Duration::MAX; 2];
    for _ in 0..3 {
        let timings = gpu.render(view, &recipe)?.timings;
        let times = [timings.cast, timings.receive];
        for (least, time) in least.iter_mut().zip(times) {
            // A stage without work has no time.
            *least = (*least).min(time.unwrap_or_default());
        }
    }
    Ok(least)
}

/// Returns the casters that hide the light from a receiver: one, or the two sides of a closed mesh.
fn fewest_blockers(
    view: &View<'_>,
    geometry: &Geometry,
    receivers: &Receivers,
    expected: &[f32],
) -> Vec<usize> {
    let sampler = LightSampler::new(view.light);
    let eye = view.camera.eye();
    let far = 2.0 * geometry.bounds().diagonal();
    let is_dark = |&i: &usize| receivers.receives[i] && expected[i] == 0.0;
    let dark: Vec<usize> = (0..receivers.len()).filter(is_dark).collect();
    let sampled = dark.iter().step_by((dark.len() / SAMPLED).max(1));
    let mut fewest: Vec<usize> = Vec::new();
    for &i in sampled {
        let normal = receivers.normal(i);
        let extent = geometry.receiver_reach();
        let o = ray_origin(receivers.position(i), normal, eye, extent);
        let d = segment(&sampler, o, Vec2::ZERO, far);
        if normal.dot(d) <= 0.0 {
            continue;
        }
        let hits = |&id: &u32| {
            let [a, b, c] = geometry.corners(id);
            id != receivers.triangle[i] && segment_hits(o, d, a, b, c)
        };
        let most = if fewest.is_empty() {
            usize::MAX
        } else {
            fewest.len()
        };
        let blockers = geometry.casters().filter(hits).take(most);
        let blockers: Vec<usize> = blockers.map(|id| id as usize).collect();
        if !blockers.is_empty() && blockers.len() < most {
            fewest = blockers;
        }
        if fewest.len() == 1 {
            break;
        }
    }
    fewest
}

/// Returns the word at which a field begins.
fn word_of(fields: &[(&'static str, u64)], name: &str) -> Result<usize> {
    let field = fields.iter().find(|(known, _)| *known == name);
    let (_, bytes) = field.with_context(|| format!("no uniform `{name}`"))?;
    Ok(*bytes as usize / 4)
}

/// Turns a directional light's frame around its rays, so that the world's verticals are along one
/// of its axes. Upright edges, which most scenes have, then have narrow rectangles.
fn turn_upright(
    fields: &[(&'static str, u64)],
    kernel: &mut [u32],
    grid: &mut [u32],
) -> Result<()> {
    let [across_at, down_at] = [word_of(fields, "across")?, word_of(fields, "down")?];
    let row = |first: usize| Vec3::from_array([0, 1, 2].map(|i| f32::from_bits(kernel[first + i])));
    let [across, down] = [row(across_at), row(down_at)];
    // Parts of the upright direction along both rows.
    let Some(up) = Vec2::new(across.y, down.y).try_normalize() else {
        return Ok(());
    };
    let turned = [across * up.y - down * up.x, across * up.x + down * up.y];
    for (i, v) in turned.iter().enumerate() {
        for (part, value) in v.to_array().iter().enumerate() {
            kernel[[across_at, down_at][i] + part] = value.to_bits();
            grid[4 + 4 * i + part] = value.to_bits();
        }
    }
    // The face contains the turned one.
    let half_at = word_of(fields, "grid")?;
    let half = Vec2::new(
        f32::from_bits(kernel[half_at]),
        f32::from_bits(kernel[half_at + 1]),
    );
    let up = up.abs();
    let half = Vec2::new(half.x * up.y + half.y * up.x, half.x * up.x + half.y * up.y);
    let tiles_a_unit = f32::from_bits(kernel[half_at + 2]);
    let tiles_at = word_of(fields, "tiles")?;
    for (part, value) in half.to_array().iter().enumerate() {
        kernel[half_at + part] = value.to_bits();
        kernel[tiles_at + part] = (2.0 * value * tiles_a_unit).ceil() as u32;
        grid[16 + part] = value.to_bits();
    }
    Ok(())
}
