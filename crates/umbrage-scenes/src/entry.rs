//! Catalogue entries of built-in scenes.

use umbrage_core::glam::Vec3;
use umbrage_core::{Fit, Geometry, Scene};

/// A built-in scene: its name, its purpose, and its constructor.
#[derive(Clone, Copy, Debug)]
pub struct SceneEntry {
    /// Name of the scene, in lower case with dashes.
    pub name: &'static str,
    /// One line for lists.
    pub summary: &'static str,
    /// Purpose of the scene.
    pub kind: Kind,
    /// `true` if the scene is in the default suite: neither heavy nor similar to another scene.
    pub suite: bool,
    /// `true` if `compare --quick` includes it: a few scenes that differ, of fewer than a million
    /// triangles.
    pub quick: bool,
    /// Builds the scene, deterministically.
    pub build: fn() -> Scene,
    /// The light space of the textbook. `None` if a tight fit is suitable.
    pub fit: Option<Fit>,
    /// Greatest share of pixels facing the light that comparisons may leave out as ambiguous. `None`
    /// for the limit of all scenes.
    pub max_left_out: Option<f64>,
    /// Points with analytic visibility. `None` for most scenes.
    pub closed_form: Option<fn() -> ClosedForm>,
}

/// Purpose of a built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A scene of textbooks and tutorials.
    Textbook,
    /// A scene whose shadow follows from a formula.
    ClosedForm,
    /// A scene with a single cause of error.
    Cause,
    /// A scene in which shadow methods fail.
    Failure(Failure),
    /// A large scene, for measuring speed.
    Speed,
    /// A scene like those of games and films: many objects, near and far.
    Content,
}

impl Kind {
    /// Reports whether scenes of this kind have the triangles and the image size of a game's frame.
    pub fn is_full_size(self) -> bool {
        matches!(self, Self::Speed | Self::Content)
    }
}

/// The failures that built-in scenes provoke. The numbers are those of the project's catalogue of
/// failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Failure {
    /// A constant bias or a wide kernel under a low sun: acne.
    LowSun = 1,
    /// Near and far receivers under one bias, which only suits one of them.
    DistantReceivers = 2,
    /// A thin caster on the ground: its shadow is detached.
    ThinContact = 3,
    /// Thin walls: light leaks in.
    SealedRoom = 4,
    /// Open shells, leaves, single quads: methods for closed casters lose part of their shadow.
    OpenShell = 5,
    /// Thin slices above each other: moments blend their depths, and a bias confuses neighbours.
    ThinSlices = 6,
    /// Two casters behind each other under an area light: one penumbra combines both.
    TwoBlockers = 7,
    /// Casters just above the floor: light leaks in at the contact.
    NearContact = 8,
    /// Wires as thin as a texel: they flicker.
    FineDetail = 9,
    /// A wide landscape under a low sun: nearby texels are far larger than pixels.
    Landscape = 10,
    /// A landscape far from the origin: positions are imprecise.
    FarFromOrigin = 11,
    /// The camera looks towards the light: perspective warps degenerate.
    IntoLight = 14,
    /// A light among its casters: the faces of a cube map meet in seams.
    CubeSeams = 15,
    /// Casters at increasing heights under an area light: each penumbra has its own width.
    RisingHeights = 17,
    /// A canopy of leaves under a large area light: many penumbrae overlap and combine.
    Canopy = 18,
    /// Two lights on one caster: their errors add up.
    TwoLights = 19,
    /// A caster too close to the light: its shadow is missing.
    CasterAtLight = 20,
    /// The eye inside a shadow whose volume the near plane clips: counts start at a wrong value.
    EyeInUmbra = 21,
    /// Duplicate faces, T-junctions, open edges: silhouettes are not closed.
    BrokenMesh = 22,
    /// Very many casters under a low sun: shadow volumes cover the image many times.
    ManyVolumes = 23,
    /// Stairs and casters beyond the light: wrong planes, shadows of casters behind the light.
    Stairs = 24,
    /// Relief under grazing light: biases along the shading normal, relief from a normal map, or a
    /// depth pass without displacement.
    Relief = 25,
    /// A large range of depths: coarse maps distinguish few of them.
    LongRange = 26,
    /// A light along the up axis: look-at views degenerate.
    LightAlongUp = 27,
    /// Very small and very large scenes: biases in absolute units.
    Scale = 28,
    /// No casters, no receivers or no visible geometry: empty fits.
    Nothing = 29,
    /// A caster out of view whose shadow is in view: the caster is clipped.
    CasterOutOfView = 30,
    /// Corners of rooms: kernels and biases cross the neighbouring wall.
    RoomCorner = 31,
    /// The rim of a spot's cone, where its map ends.
    ConeRim = 32,
    /// A light whose penumbra is narrower than a texel: a penumbra width near zero.
    SmallLight = 33,
    /// Few large facets near the terminator, which light grazes.
    LowPoly = 34,
    /// Other renderers' projections: reversed depth, no far plane.
    OtherProjection = 35,
    /// Alpha-tested leaves: holes finer than a map's texels, and finer than distant pixels.
    CutOut = 39,
    /// Blockers of two heights over one receiver: light bleeds between them in maps that blend
    /// depths.
    LightBleeding = 40,
}

impl Failure {
    /// Returns the row in the catalogue of failures.
    pub fn row(self) -> u8 {
        self as u8
    }
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Textbook => f.write_str("textbook"),
            Self::ClosedForm => f.write_str("closed form"),
            Self::Cause => f.write_str("cause"),
            Self::Failure(failure) => write!(f, "failure {}", failure.row()),
            Self::Speed => f.write_str("speed"),
            Self::Content => f.write_str("content"),
        }
    }
}

/// Points with analytic visibility.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedForm {
    /// The points.
    pub samples: Vec<Sample>,
    /// Greatest error of a correct result: 0 for points that see all or nothing of the light,
    /// otherwise the known error of stratified samples of an area light.
    pub tolerance: f32,
}

/// A surface point with known visibility.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Position in world space, metres.
    pub point: Vec3,
    /// Unit geometric normal of the surface, towards the side of the sample.
    pub normal: Vec3,
    /// The visible fraction of the light, 0 to 1.
    pub visibility: f32,
    /// The visible fraction weighted by each light point's irradiance on a diffuse surface, if
    /// known.
    pub weighted: Option<f32>,
}

impl Sample {
    /// Returns the receiver triangle that contains the sample, or the nearest one. Returns `None`
    /// if no triangle is within 1e-4 of the sample's distance from the origin, or within 1e-4 m if
    /// that is more.
    pub fn triangle(&self, geometry: &Geometry) -> Option<u32> {
        let reach = 1e-4 * self.point.length().max(1.0);
        let mut nearest = None;
        let mut least = f32::INFINITY;
        for triangle in geometry.receivers() {
            let distance = distance_outside(self.point, geometry.corners(triangle));
            if nearest.is_none() || distance < least {
                nearest = Some(triangle);
                least = distance;
            }
        }
        nearest.filter(|_| least <= reach)
    }
}

/// Returns the distance of a point from a triangle's plane or beyond one of its edges, metres,
/// whichever is greater. Points inside have 0 or less.
fn distance_outside(p: Vec3, triangle: [Vec3; 3]) -> f32 {
    let [a, b, c] = triangle;
    let n = (b - a).cross(c - a).normalize_or_zero();
    let beyond = |a: Vec3, b: Vec3| (b - a).cross(n).normalize_or_zero().dot(p - a);
    [
        (p - a).dot(n).abs(),
        beyond(a, b),
        beyond(b, c),
        beyond(c, a),
    ]
    .into_iter()
    .fold(0.0, f32::max)
}
