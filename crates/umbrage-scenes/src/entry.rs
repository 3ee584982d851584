//! What the catalogue tells about a built-in scene.

use umbrage_core::glam::Vec3;
use umbrage_core::{Fit, Geometry, Scene};

/// A built-in scene: what it is called, what it is for, and how it is made.
#[derive(Clone, Copy, Debug)]
pub struct SceneEntry {
    /// Lower case with dashes; also the scene's own name.
    pub name: &'static str,
    /// One line for lists.
    pub summary: &'static str,
    /// What it is there to show.
    pub kind: Kind,
    /// Whether it is compared when nobody names a scene: neither heavy nor nearly the same as
    /// another.
    pub suite: bool,
    /// Whether quick runs over all scenes play it. Frames of over a million triangles, and those
    /// with holes, are left to longer runs.
    pub quick: bool,
    /// Makes the scene, always the same.
    pub build: fn() -> Scene,
    /// The light space that a textbook would set by hand; none where a tight fit will do.
    pub fit: Option<Fit>,
    /// Points whose visibility is known from a formula; none for most scenes.
    pub closed_form: Option<fn() -> ClosedForm>,
}

/// What a built-in scene is there to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// As in textbooks and tutorials.
    Textbook,
    /// Its shadow is known from a formula.
    ClosedForm,
    /// A single cause of error by itself.
    Cause,
    /// A way in which shadow methods fail.
    Failure(Failure),
    /// Big: to measure speed.
    Speed,
    /// As in games and films: much of everything, near and far.
    Content,
}

/// The ways to fail that built-in scenes provoke. The numbers are those of the project's catalogue
/// of failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Failure {
    /// A constant bias or a wide kernel under a low sun: acne.
    LowSun = 1,
    /// Near and far receivers under one bias: it suits one of them.
    DistantReceivers = 2,
    /// A thin thing on the ground: the shadow parts from it.
    ThinContact = 3,
    /// Thin walls: light leaks in.
    SealedRoom = 4,
    /// Open shells, leaves, single quads: methods that take casters for closed lose part of their
    /// shadow.
    OpenShell = 5,
    /// Thin slices above each other: moments blend their depths, a bias takes one for the next.
    ThinSlices = 6,
    /// Two casters one behind the other under a lamp: one penumbra is made of both.
    TwoBlockers = 7,
    /// Casters that barely leave the floor: light leaks in at the contact.
    NearContact = 8,
    /// Wires as thin as a texel: they come and go.
    FineDetail = 9,
    /// A wide landscape under a low sun: texels are far larger than pixels nearby.
    Landscape = 10,
    /// A landscape far from the origin: positions are coarse.
    FarFromOrigin = 11,
    /// The camera looks into the light: perspective warps degenerate.
    IntoLight = 14,
    /// A light amid its casters: the faces of a cube of maps meet in seams.
    CubeSeams = 15,
    /// Casters at rising heights under a lamp: each penumbra has its own width.
    RisingHeights = 17,
    /// A canopy of leaves under a large lamp: many penumbrae overlap, and one is made of them.
    Canopy = 18,
    /// Two lights on one caster: their errors add up.
    TwoLights = 19,
    /// A caster too near to the light: lost.
    CasterAtLight = 20,
    /// The eye inside a shadow, whose volume the near plane cuts: counts start wrong.
    EyeInUmbra = 21,
    /// Duplicate faces, T-junctions, open edges: silhouettes that don't close.
    BrokenMesh = 22,
    /// Very many casters under a low sun: shadow volumes fill the picture many times over.
    ManyVolumes = 23,
    /// Stairs and casters beyond the light: wrong planes, shadows of what is behind the light.
    Stairs = 24,
    /// Relief under grazing light: biases along the shading normal, relief from normals or a depth
    /// pass that the map lacks.
    Relief = 25,
    /// A long range of depths: coarse maps tell few of them apart.
    LongRange = 26,
    /// A light along the up axis: views degenerate.
    LightAlongUp = 27,
    /// Very small and very large scenes: biases in absolute units.
    Scale = 28,
    /// Nothing casts, receives or is seen: empty fits.
    Nothing = 29,
    /// A caster out of view whose shadow is in view: clipped away.
    CasterOutOfView = 30,
    /// Corners of rooms: kernels and biases reach through the neighbouring wall.
    RoomCorner = 31,
    /// The rim of a spot's cone, where its map ends.
    ConeRim = 32,
    /// A light whose penumbra is narrower than a texel: a width of nearly nothing.
    SmallLight = 33,
    /// Few large facets near the terminator, where light grazes them.
    LowPoly = 34,
    /// Other renderers' projections: reversed depth, no far plane.
    OtherProjection = 35,
    /// Holes that alpha textures cut into leaves: finer than a map's texels, and than pixels far
    /// away.
    CutOut = 39,
    /// Blockers of two heights over one receiver: light bleeds between them where a map blends
    /// depths.
    LightBleeding = 40,
}

impl Failure {
    /// The row of the catalogue of failures.
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

/// Points whose visibility a formula tells.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedForm {
    /// The points.
    pub samples: Vec<Sample>,
    /// How far a correct answer may be off: 0 where points see all or nothing of the light; else
    /// what stratified samples of an area light are known to reach.
    pub tolerance: f32,
}

/// A surface point whose visibility is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Where, world space, metres.
    pub point: Vec3,
    /// Unit geometric normal of the surface there, towards the side that is asked about.
    pub normal: Vec3,
    /// The fraction of the light that is seen, 0 to 1.
    pub visibility: f32,
    /// The same weighted by each light point's irradiance on a diffuse surface, where it is known.
    pub weighted: Option<f32>,
}

impl Sample {
    /// The triangle of a receiver that the sample lies on: the one that it is least far outside of.
    /// None when none is within 1e-4 of the sample's distance from the origin (or of a metre, if
    /// that is more).
    pub fn triangle(&self, geometry: &Geometry) -> Option<u32> {
        let reach = 1e-4 * self.point.length().max(1.0);
        let mut nearest = None;
        let mut least = f32::INFINITY;
        for triangle in geometry.receivers() {
            let distance = outside(self.point, geometry.corners(triangle));
            if nearest.is_none() || distance < least {
                nearest = Some(triangle);
                least = distance;
            }
        }
        nearest.filter(|_| least <= reach)
    }
}

/// Returns how far a point is off a triangle's plane or beyond one of its edges, metres, whichever
/// is more; 0 or less inside.
fn outside(p: Vec3, triangle: [Vec3; 3]) -> f32 {
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
