//! A recipe's tables on the GPU.

use crate::resources::counters::ResourceFactory;
use std::sync::Arc;
use umbrage_core::Table;
use wgpu::{Buffer, BufferUsages};

/// Uploaded tables. Their rows are kept alive, so that their addresses are not reused.
#[derive(Debug, Default)]
pub(crate) struct Tables(Vec<(Arc<[[u32; 4]]>, Buffer)>);

impl Tables {
    pub(crate) fn get(&mut self, factory: &mut ResourceFactory<'_>, table: &Table) -> Buffer {
        for (rows, buffer) in &self.0 {
            if Arc::ptr_eq(rows, table.rows()) {
                return buffer.clone();
            }
        }
        let bytes: &[u8] = bytemuck::cast_slice(table.rows());
        let buffer = factory.buffer(table.label, BufferUsages::STORAGE, bytes.len() as u64);
        factory.queue.write_buffer(&buffer, 0, bytes);
        self.0.push((table.rows().clone(), buffer.clone()));
        buffer
    }

    /// Drops tables without other owners, since no recipe can refer to them any more.
    pub(crate) fn forget_unreachable(&mut self) {
        self.0.retain(|(rows, _)| Arc::strong_count(rows) > 1);
    }
}
