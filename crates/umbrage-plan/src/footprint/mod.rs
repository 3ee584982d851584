//! Use of a recipe's maps: the texels that no lookup touches, and the size of the others on screen.

#[cfg(test)]
mod lookup_tests;
#[cfg(test)]
mod tests;

use crate::catalogue::{Catalogue, kernel::CataloguedKernel};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use umbrage_core::{
    Cast, CastMode, Receivers, Recipe, View,
    footprint::{at_least, texels_per_pixel_in},
    glam::{Mat4, UVec2, Vec2, Vec3},
    math::transform,
};
use umbrage_techniques::TechniquePreset;

/// Share of receivers facing the light that [`MapUse::texels`] and [`MapUse::side`] cover. A few
/// receivers at grazing angles would need infinite resolution.
pub const QUANTILE: f32 = 0.9;

/// Greatest side of maps on common devices. No map with a greater side is advised.
const GREATEST_SIDE: u32 = 16_384;

/// Use of a recipe's maps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RecipeFootprint {
    /// One per cast that keeps the least depth, in the recipe's order.
    pub casts: Vec<CastFootprint>,
    /// Figures over all of them.
    pub total: MapUse,
}

/// Use of maps relative to their texels: screen resolution and lookups.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapUse {
    /// Share of all texels that no lookup touches, 0..=1; 0 without maps.
    pub unused: f64,
    /// Least, median and greatest number of texels in a pixel, in the direction with the fewest.
    ///
    /// They cover the visible receivers that face the light and are on a map (see
    /// [`texels_per_pixel_in`]). `None` if there are none.
    pub texels_per_pixel: Option<[f32; 3]>,
    /// Least number of texels in a pixel for a share [`QUANTILE`] of these receivers.
    pub texels: Option<f32>,
    /// Side of a map on which no texel is larger than a pixel for this share. It may exceed the
    /// greatest side of a map.
    pub side: Option<u32>,
}

impl MapUse {
    /// Returns a one-line description.
    pub fn words(&self) -> String {
        words(&[*self]).unwrap_or_default()
    }
}

/// Returns a one-line description of one map, or of the range of several. Returns `None` without
/// maps.
pub fn words(maps: &[MapUse]) -> Option<String> {
    let unused = range(maps.iter().map(|m| 100.0 * m.unused), 0)?;
    let texels = range(maps.iter().filter_map(|m| m.texels.map(f64::from)), 2);
    let sides = range(maps.iter().filter_map(|m| m.side.map(f64::from)), 0);
    let least = maps.iter().filter_map(|m| m.side).min();
    let advice = if least.is_some_and(|side| side > GREATEST_SIDE) {
        "; use cascades, or a technique without a map"
    } else {
        ""
    };
    let fine = texels.zip(sides).map(|(texels, sides)| {
        let tenths = 10.0 * QUANTILE;
        format!(
            "; {tenths:.0} in 10 pixels facing the light span at least {texels} texels (1 with a side of {sides}{advice})"
        )
    });
    Some(format!(
        "{unused} % of the map's texels never looked up{}",
        fine.unwrap_or_default()
    ))
}

/// Formats the least and the greatest figure, or a single one if both round to it. Returns `None`
/// without figures.
///
/// Figures that would round to 0 have two significant digits.
fn range(figures: impl Iterator<Item = f64> + Clone, digits: usize) -> Option<String> {
    let min = figures.clone().reduce(f64::min)?;
    let max = figures.reduce(f64::max)?;
    let rounded = |x: f64| {
        let is_small = x > 0.0 && digits > 0 && x < 0.1_f64.powi(digits as i32);
        let digits = if is_small {
            (1.0 - x.log10().floor()) as usize
        } else {
            digits
        };
        format!("{x:.digits$}")
    };
    let [min, max] = [min, max].map(rounded);
    Some(if min == max {
        max
    } else {
        format!("{min} to {max}")
    })
}

/// Use of one layer of a map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CastFootprint {
    /// Index of the image in the recipe.
    pub image: usize,
    /// Layer of the image.
    pub layer: u32,
    /// Size of the image, texels.
    pub size: [u32; 2],
    /// Number of receivers whose lookups touch each texel, rows from the top.
    pub lookups: Vec<u32>,
    /// Share of texels that no lookup touches, 0..=1.
    pub unused: f64,
}

/// Returns the use of a technique's maps in a recipe that it built for `view`, or `None` if it uses
/// no maps. `catalogue` provides the kernel's reach, and `receivers` are those visible to the
/// view's camera.
pub fn recipe_footprint(
    preset: &TechniquePreset,
    view: &View<'_>,
    recipe: &Recipe,
    receivers: &Receivers,
    catalogue: &Catalogue,
) -> Option<RecipeFootprint> {
    let reach = catalogue.kernel_reach(preset)?;
    Some(measure(
        view,
        recipe,
        receivers,
        reach,
        catalogue.kernel(recipe),
    ))
}

/// Measures the use of a recipe's maps. `receivers` are those visible to the view's camera.
///
/// `reach` is the distance, in texels, that the kernel reaches beyond a receiver's texel: 0 for
/// `hard`, the radius for `pcf`. [`CataloguedKernel::reach`] overrides it per receiver. Lookups
/// count as the whole square within reach, whether or not each of its texels is tapped. The offset
/// of receivers along their normals by a bias is neglected. Peeled layers are skipped, since their
/// lookups are those of the first layers.
pub fn measure(
    view: &View<'_>,
    recipe: &Recipe,
    receivers: &Receivers,
    reach: f32,
    kernel: &dyn CataloguedKernel,
) -> RecipeFootprint {
    let nearest = recipe
        .casts
        .iter()
        .filter(|cast| cast.mode == CastMode::Depth);
    // Count the lookups of each map.
    let casts: Vec<CastFootprint> = nearest
        .clone()
        .map(|cast| of_cast(cast, recipe, receivers, reach, kernel))
        .collect();
    let texels: usize = casts.iter().map(|c| c.lookups.len()).sum();
    let untouched: usize = casts.iter().map(CastFootprint::untouched_texels).sum();
    // Measure the texels in each pixel.
    let layers: Vec<Layer> = nearest.map(Layer::of_cast).collect();
    let size = casts.first().map_or(1, |cast| cast.size[0]) as f32;
    let mut sizes = texels_per_pixel_in(view, receivers, 1, |position, _| {
        Some(layer_at(&layers, kernel, position)?.clip_from_world)
    });
    sizes.par_sort_unstable_by(f32::total_cmp);
    let overview = sizes
        .first()
        .zip(sizes.last())
        .map(|(least, most)| [*least, sizes[sizes.len() / 2], *most]);
    let total = MapUse {
        unused: untouched as f64 / texels.max(1) as f64,
        texels_per_pixel: overview.map(|sizes| sizes.map(|texels| texels * size)),
        texels: at_least(&sizes, QUANTILE).map(|texels| texels * size),
        side: at_least(&sizes, QUANTILE).map(|texels| (1.0 / texels).ceil() as u32),
    };
    RecipeFootprint { casts, total }
}

/// Lookups of maps, downscaled for images.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Heat {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Number of receivers whose lookups touch the texels of each pixel, rows from the top;
    /// [`Heat::GAP`] between maps.
    pub lookups: Vec<u32>,
}

impl Heat {
    /// Value of pixels between maps.
    pub const GAP: u32 = u32::MAX;
    /// Distance between maps, pixels.
    const BETWEEN: u32 = 4;
    /// Maps per row.
    const COLUMNS: u32 = 3;

    /// Adds a map whose top left pixel is at (`left`, `top`). `step` x `step` texels share a pixel.
    fn add(&mut self, cast: &CastFootprint, left: u32, top: u32, step: u32) {
        let width = self.size[0];
        let rows = cast.lookups.chunks(cast.size[0].max(1) as usize);
        for (y, row) in (0..).zip(rows) {
            let start = (top + y / step) * width + left;
            for (x, &count) in (0..).zip(row) {
                let pixel = &mut self.lookups[(start + x / step) as usize];
                *pixel = if *pixel == Self::GAP {
                    count
                } else {
                    // The greatest number is reserved for gaps.
                    pixel.saturating_add(count).min(Self::GAP - 1)
                };
            }
        }
    }
}

impl RecipeFootprint {
    /// Returns all maps next to each other, three in a row, each at most `side` pixels wide.
    /// Returns `None` without maps.
    pub fn heat(&self, side: u32) -> Option<Heat> {
        let widest = self
            .casts
            .iter()
            .map(|cast| cast.size[0].max(cast.size[1]))
            .max()?;
        let step = widest.div_ceil(side.max(1)).max(1);
        // Each map has a square cell, and each pixel of it is the sum of `step` x `step` texels.
        let cell = widest.div_ceil(step);
        let pitch = cell + Heat::BETWEEN;
        let count = self.casts.len() as u32;
        let columns = count.min(Heat::COLUMNS);
        let rows = count.div_ceil(Heat::COLUMNS);
        let width = columns * pitch - Heat::BETWEEN;
        let height = rows * pitch - Heat::BETWEEN;
        let mut heat = Heat {
            size: [width, height],
            lookups: vec![Heat::GAP; width as usize * height as usize],
        };
        for (i, cast) in (0..).zip(&self.casts) {
            let left = i % Heat::COLUMNS * pitch;
            let top = i / Heat::COLUMNS * pitch;
            heat.add(cast, left, top, step);
        }
        Some(heat)
    }
}

impl CastFootprint {
    fn untouched_texels(&self) -> usize {
        self.lookups.iter().filter(|&&n| n == 0).count()
    }
}

/// Positions of a recipe's lookups on its maps, for images of texels and cascades.
///
/// ```
/// use umbrage_core::{Geometry, ShadowTechnique, View};
/// use umbrage_plan::{catalogue::Catalogue, footprint::MapPlaces};
/// use umbrage_techniques::{Exact, Hard, MapTechnique};
///
/// let scene = umbrage_scenes::by_argument("cubes")?;
/// let geometry = Geometry::bake(&scene)?;
/// let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
/// let recipe = MapTechnique::<Hard>::default().recipe(&view)?;
/// let catalogue = Catalogue::built_in();
/// let places = MapPlaces::new(&recipe, &catalogue).expect("a map");
/// let place = places.place_at(geometry.bounds().center()).expect("on the map");
/// assert_eq!(place.layer, 0);
/// assert!(place.texel.min_element() > 0.0 && place.texel.max_element() < 1024.0);
///
/// // `Exact` has per-cell triangle lists instead of a map.
/// assert!(MapPlaces::new(&Exact::default().recipe(&view)?, &catalogue).is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct MapPlaces<'a> {
    kernel: &'a dyn CataloguedKernel,
    layers: Vec<Layer>,
    /// Size of each layer, texels.
    size: Vec2,
}

/// Position on a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapPlace {
    /// Index of the map's layer: a cascade or a cube's face.
    pub layer: u32,
    /// Texels from the top left corner. The integer part is the texel's column and row.
    pub texel: Vec2,
}

impl std::fmt::Debug for MapPlaces<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MapPlaces")
            .field("layers", &self.layers.len())
            .finish_non_exhaustive()
    }
}

impl<'a> MapPlaces<'a> {
    /// Returns the lookup positions of a recipe, or `None` if it draws no map.
    pub fn new(recipe: &'a Recipe, catalogue: &Catalogue) -> Option<Self> {
        let is_map = |cast: &&Cast| cast.mode == CastMode::Depth;
        let maps: Vec<&Cast> = recipe.casts.iter().filter(is_map).collect();
        let first = maps.first()?;
        Some(Self {
            kernel: catalogue.kernel(recipe),
            layers: maps.iter().map(|cast| Layer::of_cast(cast)).collect(),
            size: recipe.images[first.image].size.as_vec2(),
        })
    }

    /// Returns the position on the map of a receiver at `position` (world space). Returns `None`
    /// behind the light or outside the map. The offset of receivers along their normals by a bias
    /// is neglected.
    pub fn place_at(&self, position: Vec3) -> Option<MapPlace> {
        let layer = layer_at(&self.layers, self.kernel, position)?;
        let texel = texel_at(layer.clip_from_world, self.size, position)?;
        let is_on_map = texel.cmpge(Vec2::ZERO).all() && texel.cmplt(self.size).all();
        is_on_map.then_some(MapPlace {
            layer: layer.index,
            texel,
        })
    }
}

/// Returns the position of a point on a map of this size, texels from the top left corner. Returns
/// `None` behind the light.
fn texel_at(clip_from_world: Mat4, size: Vec2, position: Vec3) -> Option<Vec2> {
    let clip = transform(clip_from_world, position);
    if clip.w <= 0.0 {
        return None;
    }
    let u = (clip.x / clip.w * 0.5 + 0.5) * size.x;
    let v = (0.5 - clip.y / clip.w * 0.5) * size.y;
    Some(Vec2::new(u, v))
}

/// Layer of a recipe's maps.
struct Layer {
    /// Index of the layer in its image.
    index: u32,
    view_from_world: Mat4,
    clip_from_world: Mat4,
}

impl Layer {
    fn of_cast(cast: &Cast) -> Self {
        Self {
            index: cast.layer,
            view_from_world: cast.space.view_from_world,
            clip_from_world: cast.space.clip_from_world(),
        }
    }
}

/// Returns the layer in which a receiver is looked up. It is the kernel's layer, or the one along
/// whose view the receiver is farthest, as with a cube. Returns `None` if nothing was drawn there.
fn layer_at<'a>(
    layers: &'a [Layer],
    kernel: &dyn CataloguedKernel,
    position: Vec3,
) -> Option<&'a Layer> {
    if let Some(index) = kernel.layer(position) {
        return layers.iter().find(|layer| layer.index == index);
    }
    let distance = |layer: &Layer| -transform(layer.view_from_world, position).z;
    let by_distance = |a: &&Layer, b: &&Layer| distance(a).total_cmp(&distance(b));
    layers.iter().max_by(by_distance)
}

/// Returns whether a receiver is looked up in another layer than the cast's.
fn is_on_other_layer(
    cast: &Cast,
    recipe: &Recipe,
    kernel: &dyn CataloguedKernel,
    position: Vec3,
) -> bool {
    if recipe.images[cast.image].layers == 1 {
        return false;
    }
    if let Some(index) = kernel.layer(position) {
        return index != cast.layer;
    }
    // A cube's face covers more than its own lookups; its neighbours serve the rest.
    let in_view = transform(cast.space.view_from_world, position);
    in_view.x.abs().max(in_view.y.abs()) > -in_view.z
}

/// Counts the lookups of one map.
fn of_cast(
    cast: &Cast,
    recipe: &Recipe,
    receivers: &Receivers,
    reach: f32,
    kernel: &dyn CataloguedKernel,
) -> CastFootprint {
    let image = &recipe.images[cast.image];
    let touched: Vec<[TexelSpan; 2]> = (0..receivers.len())
        .into_par_iter()
        .filter(|&i| receivers.receives[i])
        .filter_map(|i| touched_texels(cast, recipe, receivers, i, reach, kernel))
        .collect();
    let mut counts = LookupCounts::new(image.size);
    for [columns, rows] in touched {
        counts.add(columns, rows);
    }
    let mut out = CastFootprint {
        image: cast.image,
        layer: cast.layer,
        size: image.size.to_array(),
        lookups: counts.sums(),
        unused: 0.0,
    };
    out.unused = out.untouched_texels() as f64 / out.lookups.len().max(1) as f64;
    out
}

/// Returns the columns and the rows of a map that the lookup of receiver `i` touches, or `None` if
/// it is looked up elsewhere.
fn touched_texels(
    cast: &Cast,
    recipe: &Recipe,
    receivers: &Receivers,
    i: usize,
    reach: f32,
    kernel: &dyn CataloguedKernel,
) -> Option<[TexelSpan; 2]> {
    let image = &recipe.images[cast.image];
    let position = receivers.position(i);
    if is_on_other_layer(cast, recipe, kernel, position) {
        return None;
    }
    let texel = texel_at(cast.space.clip_from_world(), image.size.as_vec2(), position)?;
    let reach = kernel.reach(position, receivers.normal(i)).unwrap_or(reach);
    let columns = TexelSpan::around_coordinate(texel.x, reach, image.size.x);
    let rows = TexelSpan::around_coordinate(texel.y, reach, image.size.y);
    Some([columns, rows])
}

/// Span of texels along one axis of a map.
#[derive(Clone, Copy)]
struct TexelSpan {
    start: usize,
    /// Index after the last texel; `start` if there are none.
    end: usize,
}

impl TexelSpan {
    /// Returns the texels of a map with `side` texels along the axis that are within `reach` of a
    /// coordinate, both in texels.
    fn around_coordinate(coordinate: f32, reach: f32, side: u32) -> Self {
        let side = side as usize;
        let first = (coordinate - reach).floor();
        let last = (coordinate + reach).floor();
        // Casts saturate, and NaN becomes 0.
        let start = (first.max(0.0) as usize).min(side);
        let end = ((last + 1.0).max(0.0) as usize).min(side);
        Self {
            start,
            end: end.max(start),
        }
    }
}

/// Number of rectangles that cover each texel. Rectangles are added by their corners to a table of
/// differences, one texel larger than the map in each direction. Its sums are the counts (Crow
/// 1984, "Summed-area tables for texture mapping").
struct LookupCounts {
    size: UVec2,
    differences: Vec<i32>,
}

impl LookupCounts {
    fn new(size: UVec2) -> Self {
        Self {
            size,
            differences: vec![0; (size.x as usize + 1) * (size.y as usize + 1)],
        }
    }

    fn add(&mut self, columns: TexelSpan, rows: TexelSpan) {
        let stride = self.size.x as usize + 1;
        self.differences[rows.start * stride + columns.start] += 1;
        self.differences[rows.start * stride + columns.end] -= 1;
        self.differences[rows.end * stride + columns.start] -= 1;
        self.differences[rows.end * stride + columns.end] += 1;
    }

    fn sums(mut self) -> Vec<u32> {
        let width = self.size.x as usize;
        let height = self.size.y as usize;
        let stride = width + 1;
        for y in 0..height {
            for x in 0..width {
                let i = y * stride + x;
                let left = if x > 0 { self.differences[i - 1] } else { 0 };
                let above = if y > 0 {
                    self.differences[i - stride]
                } else {
                    0
                };
                let above_left = if x > 0 && y > 0 {
                    self.differences[i - stride - 1]
                } else {
                    0
                };
                self.differences[i] += left + above - above_left;
            }
        }
        let rows = self.differences.chunks(stride).take(height);
        rows.flat_map(|row| row[..width].iter().map(|&n| n.max(0) as u32))
            .collect()
    }
}
