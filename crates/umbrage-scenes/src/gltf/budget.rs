//! How much a file may ask for, by how many bytes it has.
//!
//! A few bytes of JSON can name the same bytes again and again, so that sizes multiply. Honest
//! files share, too: vertices among primitives, meshes among nodes, and pictures are compressed. So
//! what is allowed grows with the bytes that there are.

use umbrage_core::Invalid;

/// What any file may ask for: elements of accessors, and triangles that are placed.
const ELEMENTS: u64 = 1 << 20;
/// Texels that any file may ask for: one picture of the greatest size.
const TEXELS: u64 = 1 << 26;
/// Elements a byte: one byte is an index at best, which may bring a few numbers of a vertex that it
/// alone uses.
const ELEMENTS_A_BYTE: u64 = 16;
/// Placed triangles a byte: a node takes some 30 bytes at least, and forests have thousands that
/// show one tree.
const PLACED_A_BYTE: u64 = 64;
/// Most triangles that copies may add up to: a few gigabytes once they are placed. A file that
/// holds more of them itself may place these.
const PLACED: u64 = 1 << 26;
/// Texels a byte: pictures of one colour are compressed further, but no whole set of them.
const TEXELS_A_BYTE: u64 = 64;

/// What a file may still ask for.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReadBudget {
    bytes: u64,
    elements: u64,
    placed: u64,
    texels: u64,
}

impl ReadBudget {
    /// For a file of so many bytes.
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

    /// Counts elements that are about to be read.
    pub(super) fn read(&mut self, elements: u64) -> Result<(), Invalid> {
        self.elements = self.elements.saturating_add(elements);
        let most = ELEMENTS + ELEMENTS_A_BYTE * self.bytes;
        let what = "its vertices and indices";
        within(what, self.elements, most, "elements", self.bytes)
    }

    /// Counts triangles of an instance.
    pub(super) fn place(&mut self, triangles: usize) -> Result<(), Invalid> {
        self.placed = self.placed.saturating_add(triangles as u64);
        let copies = (ELEMENTS + PLACED_A_BYTE * self.bytes).min(PLACED);
        // A triangle takes three bytes at least.
        let most = copies.max(self.bytes / 3);
        within("its mesh", self.placed, most, "triangles", self.bytes)
    }

    /// Counts texels of a picture that are about to be decoded, or compared.
    pub(super) fn decode(&mut self, texels: u64) -> Result<(), Invalid> {
        self.texels = self.texels.saturating_add(texels);
        let most = TEXELS + TEXELS_A_BYTE * self.bytes;
        within("its pictures", self.texels, most, "texels", self.bytes)
    }
}

fn within(what: &str, asked: u64, most: u64, unit: &str, bytes: u64) -> Result<(), Invalid> {
    if asked <= most {
        return Ok(());
    }
    Err(Invalid::new(
        what,
        format!("would make {asked} {unit} of {bytes} bytes"),
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
        // By the file's length, but a million always.
        assert!(can_place(1_000, 1 << 20));
        assert!(can_place(1_000, (1 << 20) + 64_000));
        assert!(!can_place(1_000, (1 << 20) + 64_001));
        // A hundred megabytes of copies are no more than a few.
        assert!(can_place(100_000_000, 1 << 26));
        assert!(!can_place(100_000_000, (1 << 26) + 1));
        assert!(can_place(900_000_000, 300_000_000));
        assert!(!can_place(900_000_000, 300_000_001));
        // All placed together count.
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
