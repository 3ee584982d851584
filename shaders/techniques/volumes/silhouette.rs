//! Silhouette of casters relative to a light: the triangles that cap their shadow volumes, and the
//! edges that these do not share.
//!
//! Bergeron 1986, "A general version of Crow's shadow volumes", for meshes of any kind. The
//! triangles turned to the light are counted with their direction at each edge. The edge extrudes
//! as many walls as the remaining count; see also Kim, Kim and Oh 2008, "Efficient shadow volume
//! rendering for general meshes". Such walls close their volumes for any choice of triangles.

use crate::techniques::volumes::t_junctions::split_at_t_junctions;
use glam::{DVec3, DVec4, Vec3};
use umbrage_core::{Aabb, Geometry, WeldedVertices};

/// Triangles within this angle (sine) of a light's ray count as turned to it, since rounding hides
/// their orientation.
const EDGE_ON: f64 = 1e-6;

/// Light positions within this fraction of the greatest coordinate of a triangle's plane count as
/// being in it. Such a triangle casts no shadow.
const TOUCHES: f64 = 1e-6;

/// Casters, with vertices at bit-equal positions merged.
#[derive(Clone, Debug, Default)]
pub(crate) struct Welded {
    /// Vertex positions, metres, world space.
    pub(crate) positions: Vec<Vec3>,
    /// Triangles without those that repeat a vertex.
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Casters with their shells, independent of the light.
#[derive(Debug)]
pub(crate) struct CasterShells {
    pub(crate) mesh: Welded,
    shells: Shells,
}

impl CasterShells {
    pub(crate) fn new(geometry: &Geometry) -> Self {
        Self::of_mesh(Welded::new(geometry))
    }

    fn of_mesh(mesh: Welded) -> Self {
        Self {
            shells: Shells::find(&mesh),
            mesh,
        }
    }

    /// Returns the silhouette for a light in homogeneous coordinates.
    pub(crate) fn silhouette(&self, light: DVec4) -> Silhouette {
        self.mesh.silhouette(&self.shells, light)
    }
}

/// Triangle turned to the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cap {
    /// Counter-clockwise from the light.
    pub(crate) corners: [u32; 3],
    /// True if the scene contains it with its corners in the same order, so that both are drawn
    /// with equal depths.
    pub(crate) in_scene: bool,
}

/// Caps and the edges around them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Silhouette {
    pub(crate) caps: Vec<Cap>,
    pub(crate) edges: Vec<NetEdge>,
}

/// Edge that triangles contain more often in the direction from `from` to `to` than in the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NetEdge {
    pub(crate) from: u32,
    pub(crate) to: u32,
    /// Difference of the two counts, 1 or more.
    pub(crate) count: u32,
}

impl Welded {
    pub(crate) fn new(geometry: &Geometry) -> Self {
        let casters = geometry.casters();
        let triangles = &geometry.triangles()[casters.start as usize..casters.end as usize];
        let used = triangles
            .iter()
            .flatten()
            .max()
            .map_or(0, |&v| v as usize + 1);
        Self::weld(&geometry.positions()[..used], triangles)
    }

    pub(crate) fn weld(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let welded = WeldedVertices::new(positions);
        let mut out = Self::default();
        for group in 0..welded.count() as u32 {
            let first = welded.vertices(group)[0];
            out.positions.push(positions[first as usize]);
        }
        for triangle in triangles {
            let [a, b, c] = triangle.map(|v| welded.group_of()[v as usize]);
            if a != b && b != c && c != a {
                out.triangles.push([a, b, c]);
            }
        }
        out
    }

    fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|v| self.positions[v as usize].as_dvec3())
    }

    fn silhouette(&self, shells: &Shells, light: DVec4) -> Silhouette {
        // Select the triangles that cap the volumes.
        let mut caps = Vec::new();
        let mut open_caps = Vec::new();
        for (&corners, &shell) in self.triangles.iter().zip(&shells.of_triangle) {
            let away = self.faces_away(corners, light);
            match shells.shells[shell as usize].role(light) {
                Role::Fronts => {
                    if away == Some(false) {
                        caps.push(Cap {
                            corners,
                            in_scene: true,
                        });
                    }
                }
                Role::Backs => {
                    let cap = flipped_cap(corners);
                    if self.faces_away(cap.corners, light) == Some(false) {
                        caps.push(cap);
                    }
                }
                Role::All => match away {
                    None => {}
                    Some(true) => {
                        let cap = flipped_cap(corners);
                        // Test the flipped triangle again, since its rounding may differ.
                        if self.faces_away(cap.corners, light).is_some() {
                            open_caps.push(cap);
                        }
                    }
                    Some(false) => open_caps.push(Cap {
                        corners,
                        in_scene: true,
                    }),
                },
            }
        }
        // Split caps at seams, and find their outline.
        caps.extend(split_at_t_junctions(&self.positions, open_caps));
        let edges = net_edges(caps.iter().map(|cap| cap.corners));
        Silhouette { caps, edges }
    }

    /// Returns whether a triangle's front faces away from the light; `None` if the light is in its
    /// plane.
    fn faces_away(&self, corners: [u32; 3], light: DVec4) -> Option<bool> {
        let [a, b, c] = self.corners(corners);
        let n = (b - a).cross(c - a);
        let to_light = light.truncate() - a * light.w;
        let along = n.dot(to_light);
        let area = n.length();
        if light.w != 0.0 {
            let lamp = light.truncate();
            let reach = [a, b, c, lamp]
                .map(|p| p.abs().max_element())
                .into_iter()
                .fold(0.0, f64::max);
            let at_corner = [a, b, c].contains(&lamp);
            if at_corner || along.abs() < TOUCHES * area * reach {
                return None;
            }
        }
        Some(along < -EDGE_ON * area * to_light.length())
    }
}

/// Returns the cap of a triangle whose back faces the light.
fn flipped_cap(corners: [u32; 3]) -> Cap {
    let [a, b, c] = corners;
    Cap {
        corners: [a, c, b],
        in_scene: false,
    }
}

/// Returns the edges of triangles with the two directions of each subtracted, sorted by their
/// lower, then their higher end.
pub(crate) fn net_edges(triangles: impl Iterator<Item = [u32; 3]>) -> Vec<NetEdge> {
    let mut edges: Vec<(u64, i32)> = triangles.flat_map(directed_edges).collect();
    edges.sort_unstable();
    let mut out = Vec::new();
    for same_edge in edges.chunk_by(|a, b| a.0 == b.0) {
        let key = same_edge[0].0;
        let low = (key >> 32) as u32;
        let high = key as u32;
        let net: i32 = same_edge.iter().map(|(_, direction)| direction).sum();
        if net != 0 {
            out.push(NetEdge {
                from: if net > 0 { low } else { high },
                to: if net > 0 { high } else { low },
                count: net.unsigned_abs(),
            });
        }
    }
    out
}

/// Returns a triangle's three edges: both ends as one number, with the lower end in its upper half.
/// The second value is 1 if the triangle has them in that order, else -1.
fn directed_edges(corners: [u32; 3]) -> [(u64, i32); 3] {
    let [a, b, c] = corners;
    [
        directed_edge(a, b),
        directed_edge(b, c),
        directed_edge(c, a),
    ]
}

fn directed_edge(from: u32, to: u32) -> (u64, i32) {
    let key = (u64::from(from.min(to)) << 32) | u64::from(from.max(to));
    (key, if from < to { 1 } else { -1 })
}

/// Selection of the triangles of a shell that cast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// Triangles whose front faces the light. The shell is closed, its fronts are outside, and so
    /// is the light.
    Fronts,
    /// Triangles whose back faces the light. The shell is closed, its fronts are inside, and the
    /// light is outside.
    Backs,
    /// All triangles, each turned to the light.
    All,
}

/// Triangles that are connected by edges.
#[derive(Clone, Copy, Debug)]
struct Shell {
    /// True if its triangles have each edge equally often in both directions. Then the winding
    /// number around a point is an integer, and a ray from outside enters before it leaves.
    closed: bool,
    /// Six times the signed volume.
    volume: f64,
    bounds: Aabb,
}

/// Shells of a mesh.
#[derive(Debug)]
struct Shells {
    /// Index in `shells` for each triangle.
    of_triangle: Vec<u32>,
    /// One entry per triangle: a shell has the index of its first triangle, and all others are
    /// empty.
    shells: Vec<Shell>,
}

impl Shell {
    const EMPTY: Self = Self {
        closed: true,
        volume: 0.0,
        bounds: Aabb::EMPTY,
    };

    fn role(&self, light: DVec4) -> Role {
        let p = light.truncate().as_vec3();
        let inside =
            light.w != 0.0 && p.cmpge(self.bounds.min).all() && p.cmple(self.bounds.max).all();
        if !self.closed || inside || self.volume == 0.0 {
            return Role::All;
        }
        if self.volume > 0.0 {
            Role::Fronts
        } else {
            Role::Backs
        }
    }
}

impl Shells {
    fn find(mesh: &Welded) -> Self {
        // Collect each edge's ends, its triangle, and its direction: see `directed_edges`.
        let mut edges: Vec<(u64, u32, i32)> = Vec::with_capacity(3 * mesh.triangles.len());
        for (triangle, &corners) in (0..).zip(&mesh.triangles) {
            for (key, direction) in directed_edges(corners) {
                edges.push((key, triangle, direction));
            }
        }
        edges.sort_unstable();
        // Unite triangles that share an edge.
        let mut sets = DisjointSets::new(mesh.triangles.len());
        let mut at_borders = Vec::new();
        for same_edge in edges.chunk_by(|a, b| a.0 == b.0) {
            for pair in same_edge.windows(2) {
                sets.unite(pair[0].1, pair[1].1);
            }
            let net: i32 = same_edge.iter().map(|(_, _, direction)| direction).sum();
            if net != 0 {
                at_borders.push(same_edge[0].1);
            }
        }
        // Mark shells with unbalanced edges as open.
        let of_triangle: Vec<u32> = (0..mesh.triangles.len() as u32)
            .map(|t| sets.find(t))
            .collect();
        let mut shells = vec![Shell::EMPTY; of_triangle.len()];
        for triangle in at_borders {
            let shell = of_triangle[triangle as usize];
            shells[shell as usize].closed = false;
        }
        // Compute volumes and bounds.
        for (&t, &shell) in mesh.triangles.iter().zip(&of_triangle) {
            let shell = &mut shells[shell as usize];
            // The volume of closed shells does not depend on the origin; a corner of the mesh keeps
            // numbers small.
            let origin = mesh.positions[mesh.triangles[0][0] as usize].as_dvec3();
            let [a, b, c] = mesh.corners(t).map(|p| p - origin);
            shell.volume += a.dot(b.cross(c));
            shell.bounds = shell
                .bounds
                .union(&Aabb::from_points(t.map(|v| mesh.positions[v as usize])));
        }
        Self {
            of_triangle,
            shells,
        }
    }
}

/// Disjoint sets (Tarjan 1975, "Efficiency of a good but not linear set union algorithm") with path
/// halving.
struct DisjointSets {
    parents: Vec<u32>,
}

impl DisjointSets {
    fn new(count: usize) -> Self {
        Self {
            parents: (0..count as u32).collect(),
        }
    }

    fn find(&mut self, mut i: u32) -> u32 {
        while self.parents[i as usize] != i {
            let parent = self.parents[i as usize];
            self.parents[i as usize] = self.parents[parent as usize];
            i = parent;
        }
        i
    }

    fn unite(&mut self, a: u32, b: u32) {
        let a = self.find(a);
        let b = self.find(b);
        // The lower one becomes the root, so that sets are named after their first member.
        self.parents[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
#[path = "silhouette_tests.rs"]
mod tests;
