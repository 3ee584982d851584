//! Storage buffers of a set: numbers by light, and all tables in one.

use crate::resources::counters::ResourceFactory;
use std::sync::Arc;
use umbrage_core::Table;
use wgpu::{Buffer, BufferUsages};

/// Bytes of a light's entry: `ShadowLight` in text.rs.
const ENTRY_WORDS: usize = 18;

/// Equal parts of a buffer, each with a copy on this side. What changed is written by [`upload`](Self::upload).
#[derive(Debug, Default)]
pub(crate) struct Records {
    /// Bytes of a record.
    stride: usize,
    bytes: Vec<u8>,
    /// Whether each record is in use.
    used: Vec<bool>,
    /// Records that the buffer doesn't hold yet.
    changed: Vec<usize>,
    buffer: Option<Buffer>,
}

/// What the buffers of a set took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Uploaded {
    pub(crate) bytes: u64,
    /// Whether a buffer was made anew, so that bind groups must be, too.
    pub(crate) made_buffer: bool,
}

impl Uploaded {
    pub(crate) fn add(&mut self, other: Self) {
        self.bytes += other.bytes;
        self.made_buffer |= other.made_buffer;
    }
}

impl Records {
    pub(crate) fn new(stride: u64) -> Self {
        Self {
            stride: stride as usize,
            ..Self::default()
        }
    }

    /// Takes a record into use and returns its index.
    pub(crate) fn take(&mut self) -> usize {
        if let Some(free) = self.used.iter().position(|used| !used) {
            self.used[free] = true;
            return free;
        }
        self.used.push(true);
        self.bytes.resize(self.used.len() * self.stride, 0);
        self.used.len() - 1
    }

    pub(crate) fn give_back(&mut self, index: usize) {
        self.used[index] = false;
    }

    /// Sets a record's bytes; those beyond the given ones stay 0.
    pub(crate) fn set(&mut self, index: usize, bytes: &[u8]) {
        let start = index * self.stride;
        let held = &mut self.bytes[start..start + self.stride];
        let count = bytes.len().min(held.len());
        if held[..count] == bytes[..count] {
            return;
        }
        held[..count].copy_from_slice(&bytes[..count]);
        self.changed.push(index);
    }

    /// Writes what changed. The buffer is made anew where it is too small.
    pub(crate) fn upload(&mut self, factory: &mut ResourceFactory<'_>, label: &str) -> Uploaded {
        let mut uploaded = Uploaded::default();
        let size = self.bytes.len() as u64;
        let held = self.buffer.as_ref().map_or(0, Buffer::size);
        if held < size.max(1) {
            // Whole records, so that the shader's array has as many as there is room for.
            let records = self.used.len().max(1).next_power_of_two();
            self.bytes.resize(records * self.stride, 0);
            self.used.resize(records, false);
            let room = self.bytes.len() as u64;
            let buffer = factory.buffer(label, BufferUsages::STORAGE, room.max(16));
            factory.queue.write_buffer(&buffer, 0, &self.bytes);
            self.buffer = Some(buffer);
            self.changed.clear();
            uploaded.bytes = room;
            uploaded.made_buffer = true;
            return uploaded;
        }
        if let Some(buffer) = &self.buffer {
            for &index in &self.changed {
                let start = index * self.stride;
                let part = &self.bytes[start..start + self.stride];
                factory.queue.write_buffer(buffer, start as u64, part);
                uploaded.bytes += part.len() as u64;
            }
        }
        self.changed.clear();
        uploaded
    }

    /// Returns how many records there are, in use or not.
    pub(crate) fn count(&self) -> usize {
        self.used.len()
    }

    pub(crate) fn buffer(&self) -> Option<&Buffer> {
        self.buffer.as_ref()
    }

    /// Forgets the buffer: the next upload makes and fills another.
    pub(crate) fn lose_buffer(&mut self) {
        self.buffer = None;
    }
}

/// Where a kernel finds an image or a table: see `ShadowInput` in text.rs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct InputPlace {
    pub(crate) at: u32,
    pub(crate) first: u32,
}

/// A light's entry: twin of `ShadowLight` in text.rs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LightEntry {
    pub(crate) kind: u32,
    pub(crate) kernel: u32,
    pub(crate) images: [InputPlace; 4],
    pub(crate) tables: [InputPlace; 4],
}

impl LightEntry {
    /// Bytes of an entry.
    pub(crate) const BYTES: u64 = 4 * ENTRY_WORDS as u64;

    pub(crate) fn words(&self) -> [u32; ENTRY_WORDS] {
        let mut words = [0; ENTRY_WORDS];
        words[0] = self.kind;
        words[1] = self.kernel;
        let places = self.images.iter().chain(&self.tables);
        for (i, place) in places.enumerate() {
            words[2 + 2 * i] = place.at;
            words[3 + 2 * i] = place.first;
        }
        words
    }
}

/// All tables of all lights in one buffer. Lights whose tables are the same share them.
#[derive(Debug, Default)]
pub(crate) struct SharedTables {
    held: Vec<HeldTable>,
    buffer: Option<Buffer>,
    /// Rows that the buffer holds, from its beginning.
    written: u32,
}

#[derive(Debug)]
struct HeldTable {
    rows: Arc<[[u32; 4]]>,
    first: u32,
}

impl SharedTables {
    /// Returns where a table is, and puts it there first where it is new.
    pub(crate) fn place(&mut self, table: &Table) -> InputPlace {
        let count = table.rows.len() as u32;
        let known = self
            .held
            .iter()
            .find(|held| Arc::ptr_eq(&held.rows, &table.rows) || held.rows == table.rows);
        if let Some(held) = known {
            return InputPlace {
                at: held.first,
                first: count,
            };
        }
        let first = self.rows();
        self.held.push(HeldTable {
            rows: table.rows.clone(),
            first,
        });
        InputPlace {
            at: first,
            first: count,
        }
    }

    /// Keeps only the tables for which `is_used`, and moves them together. Returns whether any moved: then all places are to be asked
    /// for again.
    pub(crate) fn retain(&mut self, is_used: impl Fn(&Arc<[[u32; 4]]>) -> bool) -> bool {
        let before = self.held.len();
        self.held.retain(|held| is_used(&held.rows));
        if self.held.len() == before {
            return false;
        }
        let mut first = 0;
        for held in &mut self.held {
            held.first = first;
            first += held.rows.len() as u32;
        }
        self.written = 0;
        true
    }

    /// Writes what is new.
    pub(crate) fn upload(&mut self, factory: &mut ResourceFactory<'_>) -> Uploaded {
        let mut uploaded = Uploaded::default();
        let size = 16 * u64::from(self.rows()).max(1);
        let held = self.buffer.as_ref().map_or(0, Buffer::size);
        if held < size {
            let room = size.next_power_of_two();
            self.buffer = Some(factory.buffer("umbrage tables", BufferUsages::STORAGE, room));
            self.written = 0;
            uploaded.made_buffer = true;
        }
        if let Some(buffer) = &self.buffer {
            for table in self.held.iter().filter(|table| table.first >= self.written) {
                let bytes: &[u8] = bytemuck::cast_slice(&table.rows);
                factory
                    .queue
                    .write_buffer(buffer, 16 * u64::from(table.first), bytes);
                uploaded.bytes += bytes.len() as u64;
            }
        }
        self.written = self.rows();
        uploaded
    }

    pub(crate) fn buffer(&self) -> Option<&Buffer> {
        self.buffer.as_ref()
    }

    /// Forgets the buffer: the next upload makes and fills another.
    pub(crate) fn lose_buffer(&mut self) {
        self.buffer = None;
        self.written = 0;
    }

    fn rows(&self) -> u32 {
        self.held
            .last()
            .map_or(0, |last| last.first + last.rows.len() as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(value: u32, rows: usize) -> Table {
        Table {
            label: "table",
            rows: vec![[value; 4]; rows].into(),
        }
    }

    #[test]
    fn equal_tables_share_a_place_and_the_rest_moves_together() {
        let mut tables = SharedTables::default();
        let first = tables.place(&table(1, 3));
        let second = tables.place(&table(2, 2));
        assert_eq!((first.at, first.first), (0, 3));
        assert_eq!((second.at, second.first), (3, 2));
        assert_eq!(tables.place(&table(1, 3)), first);
        assert!(tables.retain(|rows| rows[0][0] == 2));
        assert_eq!(tables.place(&table(2, 2)).at, 0);
        assert!(!tables.retain(|_| true));
    }

    #[test]
    fn entries_are_laid_out_as_the_shader_reads_them() {
        let mut entry = LightEntry {
            kind: 1,
            kernel: 2,
            ..LightEntry::default()
        };
        entry.images[1] = InputPlace { at: 3, first: 4 };
        entry.tables[3] = InputPlace { at: 5, first: 6 };
        let words = entry.words();
        assert_eq!(words[..6], [1, 2, 0, 0, 3, 4]);
        assert_eq!(words[16..], [5, 6]);
        assert_eq!(LightEntry::BYTES, 72);
    }
}
