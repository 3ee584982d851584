use super::*;
use crate::{filtering::sample_pattern::spread, shadow_map::layers::MAX_LAYERS};
use glam::Vec4;
use umbrage_core::{Image, Simd, light_sample::hash};

/// Not a multiple of a cell's side, so that the last cells are cut.
const SIZE: u32 = 150;

/// Returns a map that is deep nearly everywhere, with some nearer texels.
fn map() -> Image {
    let desc = ImageDesc {
        label: "map",
        size: UVec2::splat(SIZE),
        layers: 1,
        format: Format::Depth32,
    };
    let mut map = Image::filled_with(desc, 1.0);
    for (i, depth) in map.texels.iter_mut().enumerate() {
        let h = hash(i as u32);
        *depth = if h.is_multiple_of(500) {
            (h >> 16) as f32 / 65_536.0
        } else {
            0.98
        };
    }
    map
}

/// Returns an ellipse whose half axes are 40 texels, and grow to the right.
fn extent() -> LightExtent {
    let half_axis_u = Vec4::new(40.0, 5.0, 0.1, 0.0);
    let half_axis_v = Vec4::new(-3.0, 30.0, 0.05, 1.5);
    LightExtent {
        half_axis_u: [half_axis_u; MAX_LAYERS],
        half_axis_v: [half_axis_v; MAX_LAYERS],
    }
}

fn grid(map: &Image, shape: PatternShape) -> Image {
    let mut maps = Maps {
        images: vec![map.desc],
        ..Maps::default()
    };
    add(&mut maps, SIZE, false, shape, extent());
    let mut image = map.clone();
    for filter in &maps.filters {
        let mut out = Image::filled_with(maps.images[filter.output], 0.0);
        let side = out.desc.size.x as usize;
        for (y, row) in out.texels.chunks_mut(side).enumerate() {
            let inputs = Inputs {
                images: &[image.view()],
                simd: Simd::Native,
            };
            filter
                .kernel
                .filter(&inputs, UVec2::new(0, y as u32), 0, row);
        }
        image = out;
    }
    image
}

/// No blocker is nearer than its cell's bound, and the bounds are tighter than the map's least
/// depth.
#[test]
fn nothing_that_hides_light_is_nearer_than_the_grid_says() {
    let map = map();
    let cell = Cells::over_size(SIZE).side();
    for shape in [PatternShape::Disc, PatternShape::Square] {
        let grid = grid(&map, shape);
        let points = spread(Default::default(), shape, 64);
        let mut checked = 0;
        for i in 0..2000 {
            let unit = |k: u32| (hash(3 * i + k) >> 8) as f32 / 16_777_216.0;
            let at = Vec2::new(unit(0), unit(1)) * SIZE as f32;
            let depth = 0.5 + 0.5 * unit(2);
            let axes = light_axes(
                extent().half_axis_u[0],
                extent().half_axis_v[0],
                at - Vec2::splat(SIZE as f32 * 0.5),
            );
            let [x, y] = at.to_array().map(|v| (v as u32 / cell) as i32);
            let bound = grid.view().load(x, y, 0);
            for q in &points {
                // Sample the ray to the light's point, at every depth.
                for step in 1..40 {
                    let nearer = depth * step as f32 / 40.0;
                    let p = at
                        + Vec2::new(axes.x * q.x + axes.z * q.y, axes.y * q.x + axes.w * q.y)
                            * nearer;
                    if p.cmplt(Vec2::ZERO).any() || p.cmpge(Vec2::splat(SIZE as f32)).any() {
                        break;
                    }
                    let stored = map.view().load(p.x as i32, p.y as i32, 0);
                    // The stored depth blocks the light if it is at least as far before the
                    // receiver as the ray.
                    if depth - stored >= nearer {
                        checked += 1;
                        assert!(
                            stored >= bound,
                            "{at} {depth}: {stored} is nearer than {bound}"
                        );
                    }
                }
            }
        }
        assert!(checked > 1000, "{shape:?}: only {checked} blockers");
        let nearest = map.texels.iter().copied().fold(1.0, f32::min);
        let tighter = grid.texels.iter().filter(|&&depth| depth > nearest).count();
        assert!(
            2 * tighter > grid.texels.len(),
            "{shape:?}: {tighter} of {} cells have a tighter bound",
            grid.texels.len()
        );
    }
}

/// Cells cover the map, are few, and no reduction reads too many texels at once.
#[test]
fn cells_cover_maps_of_all_sizes() {
    for size in 1..=4096 {
        let cells = Cells::over_size(size);
        assert!(
            cells.count <= MAX_CELLS && cells.count * cells.side() >= size,
            "{size}: {cells:?}"
        );
        assert_eq!(
            size.div_ceil(cells.ratio).div_ceil(cells.ratio),
            cells.count,
            "{size}"
        );
    }
}
