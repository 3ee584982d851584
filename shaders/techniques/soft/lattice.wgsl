// Twin of lattice.rs: reads the lattices' table (table_2).

// Maximum number of rows, and of points of a row.
const MAX_ROWS = 31;
// Number of horizontally adjacent pixels that share a lattice.
const NEIGHBOURS = 8u;

// Lattice: the start of its rows in table_2, and its vectors.
struct Lattice {
    at: u32,
    points: u32,
    step: vec2f,
    rise: vec2f,
    origin: vec2f,
}

fn lattice_of(pixel: vec2u) -> Lattice {
    let number = seed(pixel.x / NEIGHBOURS, pixel.y) % kernel.lattices;
    let at = number * (kernel.rows + 2u);
    let head = table_2[at];
    let rest = table_2[at + 1u];
    let vectors = bitcast<vec4f>(head);
    return Lattice(at + 2u, rest.z, vectors.xy, vectors.zw, bitcast<vec2f>(rest.xy));
}
