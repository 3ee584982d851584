//! Buffers of a light set: one for the uniforms of all lights, and one for all tables.

use crate::{
    light_set::ids::LightKey,
    resources::counters::{ResourceFactory, is_kept},
};
use std::sync::Arc;
use umbrage_core::Table;
use wgpu::{Buffer, BufferUsages, Queue};

/// Greatest number of images of a kernel.
pub(crate) const MAX_IMAGES: usize = 4;
/// Greatest number of tables of a kernel.
pub(crate) const MAX_TABLES: usize = 5;
/// Greatest number of images of a kernel with all tables: the last table uses the space of further
/// images.
pub(crate) const MAX_IMAGES_WITH_ALL_TABLES: usize = 1;
/// Words of a light's entry: `ShadowLight` in light.wgsl.
const ENTRY_WORDS: usize = 12;
/// Greatest number of lights of a set, and of records of a kind: an index uses 12 bits of a light's
/// entry.
pub(crate) const MAX_LIGHTS: usize = 1 << 12;
/// Greatest number of layers of a texture that lights can refer to: the index of the first one uses
/// 12 bits of a light's entry.
pub(crate) const MAX_NAMED_LAYERS: u32 = 1 << 12;
/// Number of lights of each kind for which shaders have room at least, if they fit.
const LEAST_ROOM: usize = 8;
/// Stride granularity of arrays in uniform buffers, bytes.
const UNIFORM_STEP: u64 = 16;

/// Records of the light entries, or of the uniforms of one kind of kernel: equal parts of the
/// buffer, with a copy on the CPU.
#[derive(Clone, Debug, Default)]
pub(crate) struct Records {
    /// Bytes of a record.
    stride: usize,
    bytes: Vec<u8>,
    /// True for records in use.
    used: Vec<bool>,
    /// Records that the buffer doesn't contain yet.
    changed: Vec<usize>,
    /// Number of records that fit in the buffer.
    capacity: usize,
    /// Offset of the first record in the buffer, bytes.
    offset: u64,
}

/// Result of an upload to the buffers of a set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Uploaded {
    pub(crate) bytes: u64,
    /// True if a new buffer was created, which bind groups must bind.
    pub(crate) made_buffer: bool,
}

impl Uploaded {
    pub(crate) fn add(&mut self, other: Self) {
        self.bytes += other.bytes;
        self.made_buffer |= other.made_buffer;
    }
}

impl Records {
    /// Returns an empty list of records of this size in bytes.
    pub(crate) fn new(bytes: u64) -> Self {
        Self {
            stride: bytes.next_multiple_of(UNIFORM_STEP) as usize,
            ..Self::default()
        }
    }

    /// Allocates a record and returns its index.
    pub(crate) fn take(&mut self) -> usize {
        let free = self.used.iter().position(|used| !used);
        let index = free.unwrap_or_else(|| self.push());
        self.used[index] = true;
        index
    }

    /// Adds a free record, and returns its index.
    pub(crate) fn push(&mut self) -> usize {
        self.used.push(false);
        self.bytes.resize(self.used.len() * self.stride, 0);
        self.used.len() - 1
    }

    pub(crate) fn give_back(&mut self, index: usize) {
        self.used[index] = false;
    }

    /// Sets a record's bytes; those after the given ones stay 0.
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

    /// Returns the number of records, in use or not.
    pub(crate) fn count(&self) -> usize {
        self.used.len()
    }

    /// Returns the number of records that fit in the buffer.
    pub(crate) fn capacity(&self) -> usize {
        self.capacity
    }

    /// Returns the bytes of a record.
    pub(crate) fn stride(&self) -> u64 {
        self.stride as u64
    }

    /// Returns the number of records, at least `least`.
    fn count_from(&self, least: usize) -> u64 {
        self.count().max(least) as u64
    }

    /// Writes all records.
    fn write_all(&mut self, queue: &Queue, buffer: &Buffer) -> u64 {
        self.changed.clear();
        if !self.bytes.is_empty() {
            queue.write_buffer(buffer, self.offset, &self.bytes);
        }
        self.bytes.len() as u64
    }

    /// Writes the records that changed.
    fn write_changed(&mut self, queue: &Queue, buffer: &Buffer) -> u64 {
        let mut bytes = 0;
        for &index in &self.changed {
            let start = index * self.stride;
            let part = &self.bytes[start..start + self.stride];
            queue.write_buffer(buffer, self.offset + start as u64, part);
            bytes += part.len() as u64;
        }
        self.changed.clear();
        bytes
    }
}

/// Address space of the uniforms in shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NumberSpace {
    /// A uniform buffer, which most drivers read fastest.
    Uniform,
    /// A storage buffer, used if they exceed a uniform buffer.
    Storage,
}

/// Shader data of the lights: their entries, then the uniforms of each kind of kernel. All of it is
/// in one buffer.
#[derive(Clone, Debug)]
pub(crate) struct LightNumbers {
    pub(crate) entries: Records,
    /// Uniforms of the lights of each kind.
    pub(crate) kernels: Vec<Records>,
    space: NumberSpace,
    /// Greatest size of a uniform buffer, bytes.
    most_uniform_bytes: u64,
    buffer: Option<Buffer>,
}

impl LightNumbers {
    pub(crate) fn new(most_uniform_bytes: u64) -> Self {
        Self {
            entries: Records::new(LightEntry::BYTES),
            kernels: Vec::new(),
            space: NumberSpace::Uniform,
            most_uniform_bytes,
            buffer: None,
        }
    }

    pub(crate) fn space(&self) -> NumberSpace {
        self.space
    }

    pub(crate) fn buffer(&self) -> Option<&Buffer> {
        self.buffer.as_ref()
    }

    /// Drops the buffer: the next upload creates and fills another.
    pub(crate) fn lose_buffer(&mut self) {
        self.buffer = None;
    }

    /// Ensures capacity for all records. Returns whether the layout changed, and with it the
    /// shaders' declarations.
    pub(crate) fn make_room(&mut self) -> bool {
        let has_room = |list: &Records| list.capacity > 0 && list.count() <= list.capacity;
        if self.lists().all(has_room) {
            return false;
        }
        // Declare room for a few lights of each kind, so that their number seldom changes the
        // shaders, unless this exceeds a uniform buffer.
        let bytes = |least: usize| -> u64 {
            let lists = self.lists();
            lists
                .map(|list| list.count_from(least) * list.stride())
                .sum()
        };
        let least = if bytes(LEAST_ROOM) <= self.most_uniform_bytes {
            LEAST_ROOM
        } else {
            1
        };
        let needed = bytes(least);
        let fits = needed <= self.most_uniform_bytes;
        self.space = if fits {
            NumberSpace::Uniform
        } else {
            NumberSpace::Storage
        };
        // Grow each list by the same factor, so that lights can be added for a while without
        // changing shaders. Use the whole uniform buffer, or twice the needed size.
        let room = if fits {
            self.most_uniform_bytes
        } else {
            2 * needed
        };
        let mut offset = 0;
        for list in std::iter::once(&mut self.entries).chain(&mut self.kernels) {
            let count = list.count_from(least);
            let capacity = (count * room / needed).min(MAX_LIGHTS as u64);
            list.capacity = capacity as usize;
            list.offset = offset;
            offset += capacity * list.stride();
        }
        self.buffer = None;
        true
    }

    /// Writes the changes, or everything if there is no buffer yet.
    pub(crate) fn upload(&mut self, factory: &mut ResourceFactory<'_>) -> Uploaded {
        let mut uploaded = Uploaded::default();
        let size = self
            .lists()
            .map(|list| list.capacity as u64 * list.stride())
            .sum();
        let lists = std::iter::once(&mut self.entries).chain(&mut self.kernels);
        if let Some(buffer) = &self.buffer {
            uploaded.bytes = lists
                .map(|list| list.write_changed(factory.queue, buffer))
                .sum();
            return uploaded;
        }
        let usage = match self.space {
            NumberSpace::Uniform => BufferUsages::UNIFORM,
            NumberSpace::Storage => BufferUsages::STORAGE,
        };
        let buffer = factory.buffer("umbrage lights", usage, size);
        uploaded.bytes = lists
            .map(|list| list.write_all(factory.queue, &buffer))
            .sum();
        uploaded.made_buffer = true;
        self.buffer = Some(buffer);
        uploaded
    }

    fn lists(&self) -> impl Iterator<Item = &Records> {
        std::iter::once(&self.entries).chain(&self.kernels)
    }
}

/// Position of an image: the index of its texture, and the first of its layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ImagePlace {
    pub(crate) texture: u32,
    pub(crate) first: u32,
}

/// Position of a table: its first row, and the number of rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct TablePlace {
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// A light's entry: twin of `ShadowLight` in light.wgsl.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LightEntry {
    /// 0 for lights without shadows, otherwise the kind of kernel, counted from 1.
    pub(crate) kind: u32,
    /// Index of the kernel's uniforms.
    pub(crate) kernel: u32,
    pub(crate) images: [ImagePlace; MAX_IMAGES],
    /// The last one is stored in place of images 1 to 3.
    pub(crate) tables: [TablePlace; MAX_TABLES],
}

impl LightEntry {
    /// Bytes of an entry.
    pub(crate) const BYTES: u64 = 4 * ENTRY_WORDS as u64;

    pub(crate) fn words(&self) -> [u32; ENTRY_WORDS] {
        let first = self.images.map(|image| image.first);
        let texture = self.images.map(|image| image.texture);
        let mut words = [0; ENTRY_WORDS];
        words[0] = self.kind | self.kernel << 8 | first[0] << 20;
        words[1] = texture[0] | texture[1] << 8 | texture[2] << 16 | texture[3] << 24;
        words[2] = first[1] | first[2] << 16;
        words[3] = first[3];
        let [tables @ .., last] = self.tables;
        for (i, table) in tables.iter().enumerate() {
            words[4 + i] = table.first;
            words[8 + i] = table.count;
        }
        if last.count > 0 {
            words[2] = last.count;
            words[3] = last.first;
        }
        words
    }
}

/// All tables of all lights in one buffer. Lights with equal tables share them.
#[derive(Debug, Default)]
pub(crate) struct SharedTables {
    held: Vec<HeldTable>,
    buffer: Option<Buffer>,
    /// Number of rows in the buffer, from its beginning.
    written: u32,
    moves: u64,
}

/// Rows written by the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Region {
    /// Corners of all casters.
    Corners,
    /// The hierarchy of a light.
    Light(LightKey),
}

#[derive(Debug)]
struct HeldTable {
    content: Content,
    first: u32,
    count: u32,
}

#[derive(Debug)]
enum Content {
    Rows(Arc<[[u32; 4]]>),
    Made(Region),
}

impl Content {
    fn is(&self, region: Region) -> bool {
        matches!(self, Self::Made(made) if *made == region)
    }

    fn is_rows(&self, rows: &Arc<[[u32; 4]]>) -> bool {
        matches!(self, Self::Rows(held) if Arc::ptr_eq(held, rows) || held == rows)
    }
}

impl SharedTables {
    /// Returns the position of a table; adds it if it is new.
    pub(crate) fn place(&mut self, table: &Table) -> TablePlace {
        let known = self
            .held
            .iter()
            .find(|held| held.content.is_rows(table.rows()));
        if let Some(held) = known {
            return held.place();
        }
        self.push(
            Content::Rows(table.rows().clone()),
            table.rows().len() as u32,
        )
    }

    /// Ensures that a region's size [`is_kept`] for `count` rows. Returns whether its position
    /// changed.
    pub(crate) fn reserve(&mut self, region: Region, count: u32) -> bool {
        let known = self.held.iter().find(|held| held.content.is(region));
        if known.is_some_and(|held| is_kept(held.count.into(), count.into())) {
            return false;
        }
        self.free(region);
        self.push(Content::Made(region), count);
        self.moves += 1;
        true
    }

    /// Frees a region, if it is reserved. Returns whether it was.
    pub(crate) fn free(&mut self, region: Region) -> bool {
        let before = self.held.len();
        self.held.retain(|held| !held.content.is(region));
        let was_reserved = self.held.len() != before;
        if was_reserved {
            self.pack();
        }
        was_reserved
    }

    /// Frees all regions.
    pub(crate) fn free_regions(&mut self) {
        self.held
            .retain(|held| matches!(held.content, Content::Rows(_)));
        self.pack();
    }

    /// Returns a region's position, which is empty if it wasn't reserved.
    pub(crate) fn place_of(&self, region: Region) -> TablePlace {
        let known = self.held.iter().find(|held| held.content.is(region));
        known.map_or_else(TablePlace::default, HeldTable::place)
    }

    /// Returns the bytes of all tables except a light's region.
    pub(crate) fn bytes_without(&self, light: LightKey) -> u64 {
        self.bytes_of(|content| !content.is(Region::Light(light)))
    }

    /// Returns the bytes of all regions.
    pub(crate) fn region_bytes(&self) -> u64 {
        self.bytes_of(|content| matches!(content, Content::Made(_)))
    }

    /// Returns the bytes of all other tables.
    pub(crate) fn fixed_bytes(&self) -> u64 {
        self.bytes_of(|content| matches!(content, Content::Rows(_)))
    }

    fn bytes_of(&self, is_counted: impl Fn(&Content) -> bool) -> u64 {
        let counted = self.held.iter().filter(|held| is_counted(&held.content));
        16 * counted.map(|held| u64::from(held.count)).sum::<u64>()
    }

    /// Returns a number that grows whenever rows of the device are lost or moved.
    pub(crate) fn moves(&self) -> u64 {
        self.moves
    }

    /// Keeps only the tables for which `is_used`, and the regions of lights for which `is_built`.
    /// Compacts the rest. Returns whether any moved, which invalidates all positions.
    pub(crate) fn retain(
        &mut self,
        is_used: impl Fn(&Arc<[[u32; 4]]>) -> bool,
        is_built: impl Fn(LightKey) -> bool,
    ) -> bool {
        let before = self.held.len();
        self.held.retain(|held| match &held.content {
            Content::Rows(rows) => is_used(rows),
            Content::Made(Region::Corners) => true,
            Content::Made(Region::Light(id)) => is_built(*id),
        });
        if self.held.len() == before {
            return false;
        }
        self.pack();
        true
    }

    /// Compacts all tables.
    fn pack(&mut self) {
        let mut first = 0;
        for held in &mut self.held {
            held.first = first;
            first += held.count;
        }
        self.written = 0;
        self.moves += 1;
    }

    fn push(&mut self, content: Content, count: u32) -> TablePlace {
        let held = HeldTable {
            content,
            first: self.rows(),
            count,
        };
        let place = held.place();
        self.held.push(held);
        place
    }

    /// Writes new tables.
    pub(crate) fn upload(&mut self, factory: &mut ResourceFactory<'_>) -> Uploaded {
        let mut uploaded = Uploaded::default();
        let size = 16 * u64::from(self.rows()).max(1);
        if !is_kept(self.buffer_bytes(), size) {
            let most = factory.device.limits().max_storage_buffer_binding_size;
            let room = size.next_power_of_two().min(most.max(size));
            self.buffer = Some(factory.buffer("umbrage tables", BufferUsages::STORAGE, room));
            self.written = 0;
            self.moves += 1;
            uploaded.made_buffer = true;
        }
        if let Some(buffer) = &self.buffer {
            for table in self.held.iter().filter(|table| table.first >= self.written) {
                let Content::Rows(rows) = &table.content else {
                    continue;
                };
                let bytes: &[u8] = bytemuck::cast_slice(rows);
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

    /// Returns the bytes of the buffer, 0 if there is none yet.
    pub(crate) fn buffer_bytes(&self) -> u64 {
        self.buffer.as_ref().map_or(0, Buffer::size)
    }

    /// Drops the buffer: the next upload creates and fills another.
    pub(crate) fn lose_buffer(&mut self) {
        self.buffer = None;
        self.written = 0;
    }

    fn rows(&self) -> u32 {
        self.held.last().map_or(0, |last| last.first + last.count)
    }
}

impl HeldTable {
    fn place(&self) -> TablePlace {
        TablePlace {
            first: self.first,
            count: self.count,
        }
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
        assert_eq!((first.first, first.count), (0, 3));
        assert_eq!((second.first, second.count), (3, 2));
        assert_eq!(tables.place(&table(1, 3)), first);
        assert!(tables.retain(|rows| rows[0][0] == 2, |_| true));
        assert_eq!(tables.place(&table(2, 2)).first, 0);
        assert!(!tables.retain(|_| true, |_| true));
    }

    #[test]
    fn regions_grow_and_shrink() {
        let mut tables = SharedTables::default();
        assert!(tables.reserve(Region::Corners, 100_000));
        tables.place(&table(1, 3));
        assert!(!tables.reserve(Region::Corners, 50_000));
        assert!(tables.reserve(Region::Corners, 5_000));
        assert_eq!(tables.place(&table(1, 3)).first, 0);
        assert_eq!(tables.place_of(Region::Corners).count, 5_000);
        // Small regions are kept.
        assert!(!tables.reserve(Region::Corners, 1));
        assert!(tables.free(Region::Corners) && !tables.free(Region::Corners));
        assert_eq!(tables.place_of(Region::Corners).count, 0);
    }

    #[test]
    fn entries_are_laid_out_as_the_shader_reads_them() {
        let mut entry = LightEntry {
            kind: 1,
            kernel: 2,
            ..LightEntry::default()
        };
        for i in 0..4 {
            entry.images[i as usize] = ImagePlace {
                texture: 3 + i,
                first: 7 + i,
            };
        }
        entry.tables[3] = TablePlace { first: 5, count: 6 };
        let words = entry.words();
        assert_eq!(words[0], 0x0070_0201);
        assert_eq!(words[1], 0x0605_0403);
        assert_eq!(words[2..4], [0x0009_0008, 10]);
        assert_eq!(words[7], 5);
        assert_eq!(words[11], 6);
        entry.tables[4] = TablePlace { first: 8, count: 9 };
        assert_eq!(entry.words()[2..4], [9, 8]);
        assert_eq!(LightEntry::BYTES, 48);
    }

    /// Lists use all of a uniform buffer; beyond it, they use a storage buffer.
    #[test]
    fn numbers_are_uniform_as_long_as_they_fit() {
        let mut numbers = LightNumbers::new(1 << 16);
        numbers.kernels.push(Records::new(976));
        let mut layouts = 0;
        for _ in 0..64 {
            numbers.entries.take();
            numbers.kernels[0].take();
            layouts += u32::from(numbers.make_room());
            assert_eq!(numbers.space(), NumberSpace::Uniform);
        }
        assert_eq!(layouts, 1, "one light has the full capacity");
        numbers.entries.take();
        numbers.kernels[0].take();
        assert!(numbers.make_room());
        assert_eq!(numbers.space(), NumberSpace::Storage);
        assert_eq!(numbers.entries.capacity(), 130);
        assert!(!numbers.make_room());
    }
}
