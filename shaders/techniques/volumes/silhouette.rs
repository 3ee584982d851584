//! What a light sees of casters: the triangles that cap their shadow volumes, and the edges that these do not share.
//!
//! Bergeron 1986, "A general version of Crow's shadow volumes": on meshes of any kind, each edge extrudes as many
//! walls as the triangles turned to the light leave over when they are counted with their direction; Kim, Kim and Oh
//! 2008, "Efficient shadow volume rendering for general meshes". Whatever triangles are chosen, such walls close their
//! volumes.

use crate::techniques::volumes::t_junctions::split_at_t_junctions;
use glam::{DVec3, DVec4, Vec3};
use umbrage_core::{Aabb, Geometry, WeldedVertices};

/// Triangles within this angle (sine) of a light's ray count as turned to it, as rounding cannot tell.
const EDGE_ON: f64 = 1e-6;

/// Light positions within this fraction of the greatest coordinate of a triangle's plane lie in it: such a triangle
/// hides nothing from anywhere else.
const TOUCHES: f64 = 1e-6;

/// Casters, with vertices at bit-equal positions made one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Welded {
    /// Metres, world space.
    pub(crate) positions: Vec<Vec3>,
    /// Without those that have a vertex twice.
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// A triangle turned to the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cap {
    /// Counter-clockwise seen from the light.
    pub(crate) corners: [u32; 3],
    /// Whether the scene has it with its corners in the same order, so that both are drawn with equal depths.
    pub(crate) in_scene: bool,
}

/// Caps and the edges around them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Silhouette {
    pub(crate) caps: Vec<Cap>,
    /// Edges in the direction in which the caps left over have them, and how many are left over.
    pub(crate) edges: Vec<([u32; 2], u32)>,
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
        let places = WeldedVertices::new(positions);
        let at = |v: u32| places.group_of()[v as usize];
        let whole = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        Self {
            positions: (0..places.count() as u32)
                .map(|p| positions[places.vertices(p)[0] as usize])
                .collect(),
            triangles: triangles.iter().map(|t| t.map(at)).filter(whole).collect(),
        }
    }

    fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|v| self.positions[v as usize].as_dvec3())
    }

    /// The silhouette for a light in homogeneous coordinates.
    pub(crate) fn silhouette(&self, light: DVec4) -> Silhouette {
        let shells = Shells::find(self);
        let (mut closed, mut open) = (Vec::new(), Vec::new());
        for (&corners, &shell) in self.triangles.iter().zip(&shells.of_triangle) {
            let away = |corners| self.faces_away(corners, light);
            let role = shells.shells[shell as usize].role(light);
            let flips = role == Role::Backs || role == Role::All && away(corners) == Some(true);
            let cap = if flips {
                flipped(corners)
            } else {
                Cap {
                    corners,
                    in_scene: true,
                }
            };
            match (role, away(cap.corners)) {
                (_, None) => {}
                (Role::All, _) => open.push(cap),
                (_, Some(false)) => closed.push(cap),
                _ => {}
            }
        }
        closed.extend(split_at_t_junctions(&self.positions, open));
        let edges = net_edges(closed.iter().map(|cap| cap.corners));
        Silhouette {
            caps: closed,
            edges,
        }
    }

    /// Whether a triangle's front faces away from the light; none if the light lies in it.
    fn faces_away(&self, corners: [u32; 3], light: DVec4) -> Option<bool> {
        let [a, b, c] = self.corners(corners);
        let (n, to_light) = ((b - a).cross(c - a), light.truncate() - a * light.w);
        let (along, area) = (n.dot(to_light), n.length());
        if light.w != 0.0 {
            let reach = [a, b, c, light.truncate()]
                .map(|p| p.abs().max_element())
                .into_iter()
                .fold(0.0, f64::max);
            let at_corner = [a, b, c].contains(&light.truncate());
            if at_corner || along.abs() < TOUCHES * area * reach {
                return None;
            }
        }
        Some(along < -EDGE_ON * area * to_light.length())
    }
}

fn flipped([a, b, c]: [u32; 3]) -> Cap {
    Cap {
        corners: [a, c, b],
        in_scene: false,
    }
}

/// Edges of triangles, the two directions of each subtracted from one another; sorted.
pub(crate) fn net_edges(triangles: impl Iterator<Item = [u32; 3]>) -> Vec<([u32; 2], u32)> {
    let mut edges: Vec<(u64, i32)> = triangles.flat_map(directed).collect();
    edges.sort_unstable();
    let runs = edges.chunk_by(|a, b| a.0 == b.0);
    let net = runs
        .map(|run| (run[0].0, run.iter().map(|e| e.1).sum::<i32>()))
        .filter(|&(_, net)| net != 0);
    net.map(|(key, net)| {
        let (low, high) = ((key >> 32) as u32, key as u32);
        (
            if net > 0 { [low, high] } else { [high, low] },
            net.unsigned_abs(),
        )
    })
    .collect()
}

/// A triangle's edges: both ends, the lower first, and 1 if the triangle has them in that order, else -1.
fn directed([a, b, c]: [u32; 3]) -> [(u64, i32); 3] {
    [[a, b], [b, c], [c, a]].map(|[from, to]| {
        let key = (u64::from(from.min(to)) << 32) | u64::from(from.max(to));
        (key, if from < to { 1 } else { -1 })
    })
}

/// Which triangles of a shell cast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// Those whose front faces the light: the shell is closed, its fronts are outside, and so is the light.
    Fronts,
    /// The same for a shell whose fronts are inside.
    Backs,
    /// All, each turned to the light.
    All,
}

/// Triangles that hang together by edges.
#[derive(Clone, Copy, Debug)]
struct Shell {
    /// Whether its triangles have each edge as often in one direction as in the other: then how often they wind around
    /// a point is a whole number, and a ray from outside enters before it leaves.
    closed: bool,
    /// Six times the signed volume.
    volume: f64,
    bounds: Aabb,
}

struct Shells {
    of_triangle: Vec<u32>,
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
        let edge =
            |(i, &t): (usize, &[u32; 3])| directed(t).map(|(key, sign)| (key, i as u32, sign));
        let mut edges: Vec<(u64, u32, i32)> =
            mesh.triangles.iter().enumerate().flat_map(edge).collect();
        edges.sort_unstable();
        let mut sets = Sets::new(mesh.triangles.len());
        let mut torn = Vec::new();
        for run in edges.chunk_by(|a, b| a.0 == b.0) {
            run.windows(2)
                .for_each(|pair| sets.unite(pair[0].1, pair[1].1));
            if run.iter().map(|e| e.2).sum::<i32>() != 0 {
                torn.push(run[0].1);
            }
        }
        let of_triangle: Vec<u32> = (0..mesh.triangles.len() as u32)
            .map(|t| sets.find(t))
            .collect();
        let mut shells = vec![Shell::EMPTY; of_triangle.len()];
        torn.iter()
            .for_each(|&t| shells[of_triangle[t as usize] as usize].closed = false);
        for (&t, &shell) in mesh.triangles.iter().zip(&of_triangle) {
            let shell = &mut shells[shell as usize];
            // Closed shells have the same volume seen from any origin; one of the mesh's corners keeps numbers small.
            let origin = mesh.positions[mesh.triangles[0][0] as usize].as_dvec3();
            let [a, b, c] = mesh.corners(t).map(|p| p - origin);
            shell.volume += a.dot(b.cross(c));
            shell.bounds = shell
                .bounds
                .union(&Aabb::around(t.map(|v| mesh.positions[v as usize])));
        }
        Self {
            of_triangle,
            shells,
        }
    }
}

/// Disjoint sets (Tarjan 1975, "Efficiency of a good but not linear set union algorithm"), paths halved.
struct Sets {
    parents: Vec<u32>,
}

impl Sets {
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
        let (a, b) = (self.find(a), self.find(b));
        // The lower one leads, so that sets are named after their first member.
        self.parents[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
#[path = "silhouette_tests.rs"]
mod tests;
