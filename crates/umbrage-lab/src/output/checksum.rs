//! Checksums of files, to detect changed or truncated ones, and of the program that writes them.

use std::{
    fs,
    hash::{DefaultHasher, Hash, Hasher},
};

/// Returns the 64-bit FNV-1a hash (Fowler, Noll and Vo) as sixteen hexadecimal digits. It is the
/// same for every compiler version, and differs for any two texts that differ in one character.
pub(crate) fn checksum(bytes: &[u8]) -> String {
    const OFFSET_BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0100_0000_01b3;
    let mut hash = OFFSET_BASIS;
    for &byte in bytes {
        hash = (hash ^ u64::from(byte)).wrapping_mul(PRIME);
    }
    format!("{hash:016x}")
}

/// Returns a hash of the running program. Empty if the system doesn't report its path.
pub(crate) fn program_hash() -> String {
    std::env::current_exe()
        .and_then(fs::read)
        .map(|bytes| hash(&bytes))
        .unwrap_or_default()
}

/// Returns a hash that is equal in all programs of one compiler version.
pub(crate) fn hash<T: Hash + ?Sized>(value: &T) -> String {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    format!("{:016x}", hasher.finish())
}
