//! Limits on the resources of a file, by its number of bytes.
//!
//! A few bytes of JSON can name the same bytes repeatedly, so that sizes multiply. Valid files
//! share data, too: vertices among primitives, and meshes among nodes; and images are compressed.
//! Limits therefore grow with the number of bytes.

use umbrage_core::Invalid;

/// Limit for every file: elements of accessors, and placed triangles.
const ELEMENTS: u64 = 1 << 20;
/// Limit of texels for every file: one image of the greatest size.
const TEXELS: u64 = 1 << 26;
/// Limit of elements per byte. One byte is an index at best, which may use a few numbers of a
/// vertex.
const ELEMENTS_A_BYTE: u64 = 16;
/// Limit of placed triangles per byte. A node takes at least some 30 bytes, and forests have
/// thousands of nodes with one tree.
const PLACED_A_BYTE: u64 = 64;
/// Limit of triangles in copies: a few gigabytes after placement. A file that stores more triangles
/// itself may place these.
const PLACED: u64 = 1 << 26;
/// Limit of texels per byte. Images of one colour are compressed further, but no complete set of
/// them.
const TEXELS_A_BYTE: u64 = 64;

/// The remaining limits of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReadBudget {
    bytes: u64,
    elements: u64,
    placed: u64,
    texels: u64,
}

impl ReadBudget {
    /// Creates the limits for a file of this many bytes.
    pub(super) fn new(bytes: usize) -> Self {
        Self {
            bytes: bytes as u64,
            elements: 0,
            placed: 0,
            texels: 0,
        }
    }

    /// Counts the bytes of another file.
    pub(super) fn add_bytes(&mut self, bytes: usize) {
        self.bytes += bytes as u64;
    }

    /// Counts elements before they are read.
    pub(super) fn read(&mut self, elements: u64) -> Result<(), Invalid> {
        self.elements = self.elements.saturating_add(elements);
        let most = ELEMENTS + ELEMENTS_A_BYTE * self.bytes;
        let what = "its vertices and indices";
        check_limit(what, self.elements, most, "elements", self.bytes)
    }

    /// Counts triangles of an instance.
    pub(super) fn place(&mut self, triangles: usize) -> Result<(), Invalid> {
        self.placed = self.placed.saturating_add(triangles as u64);
        let copies = (ELEMENTS + PLACED_A_BYTE * self.bytes).min(PLACED);
        // A triangle takes at least three bytes.
        let most = copies.max(self.bytes / 3);
        check_limit("its mesh", self.placed, most, "triangles", self.bytes)
    }

    /// Counts texels of an image before they are decoded or compared.
    pub(super) fn decode(&mut self, texels: u64) -> Result<(), Invalid> {
        self.texels = self.texels.saturating_add(texels);
        let most = TEXELS + TEXELS_A_BYTE * self.bytes;
        check_limit("its pictures", self.texels, most, "texels", self.bytes)
    }
}

fn check_limit(
    what: &str,
    requested: u64,
    most: u64,
    unit: &str,
    bytes: u64,
) -> Result<(), Invalid> {
    if requested <= most {
        return Ok(());
    }
    Err(Invalid::new(
        what,
        format!("would make {requested} {unit} of {bytes} bytes"),
        format!("use at most {most}, or split the model"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_are_bounded_and_triangles_of_the_file_s_own_are_not() {
        let can_place =
            |bytes: usize, triangles: usize| ReadBudget::new(bytes).place(triangles).is_ok();
        // The limit grows with the length of the file, from at least a million.
        assert!(can_place(1_000, 1 << 20));
        assert!(can_place(1_000, (1 << 20) + 64_000));
        assert!(!can_place(1_000, (1 << 20) + 64_001));
        // The limit of copies is the same for a hundred megabytes.
        assert!(can_place(100_000_000, 1 << 26));
        assert!(!can_place(100_000_000, (1 << 26) + 1));
        assert!(can_place(900_000_000, 300_000_000));
        assert!(!can_place(900_000_000, 300_000_001));
        // All placements count together.
        let mut budget = ReadBudget::new(0);
        budget.place(1 << 19).expect("half");
        budget.place(1 << 19).expect("all");
        let message = budget.place(1).expect_err("one more").to_string();
        assert!(
            message.contains("would make 1048577 triangles of 0 bytes"),
            "{message}"
        );
    }
}
