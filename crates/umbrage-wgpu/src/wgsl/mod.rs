//! WGSL: every text that this crate compiles or returns is assembled here.
//!
//! * **Imports.** A shader is a list of [`Module`](umbrage_core::Module)s, each a `.wgsl` file, which [`join`](umbrage_core::join) puts one after another (`stages.rs`).
//! * **Conditions.** A `const`, such as `NORMALS_ARE_HALVED`, selects the variant in the files that read it. Text that users compile
//!   has no `override`.
//! * **Bindings.** A kernel reads `kernel`, `load_0`, `table_0` and so on, as [`Kernel`](umbrage_core::Kernel) describes. `kernel.rs`
//!   declares them as bindings of one kernel, `set.rs` as parts of arrays that all lights of a set share.
//! * **Prefixes.** A prefix before every name that a text declares lets several texts fit into one shader.
//!
//! `resolver.rs` is the one module that changes text: constants, prefixes, and where a kernel's inputs are.

pub(crate) mod kernel;
pub(crate) mod resolver;
pub(crate) mod set;
pub(crate) mod stages;
