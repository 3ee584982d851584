//! WGSL texts and the uniforms they read.

use encase::{ShaderType, UniformBuffer, internal::WriteInto};

/// A piece of WGSL with a name. Shaders are lists of modules put one after the other; a module that
/// several kernels list is the same text, so there is nothing to keep in sync.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Module {
    /// For error messages; the stem of its file.
    pub name: &'static str,
    /// The WGSL.
    pub text: &'static str,
}

/// Makes the [`Module`](crate::Module) of the WGSL file with this stem beside the Rust file:
/// `module!("pcf")`; or of another file: `module!("soft_holes", "holes.wgsl")`.
#[macro_export]
macro_rules! module {
    ($stem:literal) => {
        $crate::module!($stem, concat!($stem, ".wgsl"))
    };
    ($name:literal, $file:expr) => {
        $crate::Module {
            name: $name,
            text: include_str!($file),
        }
    };
}

/// Returns the modules' texts, one after the other, each below a line with its file's name.
pub fn join(modules: &[Module]) -> String {
    let mut out = String::new();
    for Module { name, text } in modules {
        // Names with a colon are those of single constants, which are in no file.
        if !name.contains(':') {
            out += &format!("// ---- {name}.wgsl\n");
        }
        out += text;
        out += "\n";
    }
    out
}

/// A struct that Rust fills and WGSL reads, laid out by `encase`. Declare it with
/// [`uniforms!`](crate::uniforms).
pub trait Uniforms: ShaderType + WriteInto {
    /// The struct's name in WGSL.
    const NAME: &'static str;
    /// The fields' names, in order.
    const FIELDS: &'static [&'static str];
    /// The fields' offsets in bytes, in order.
    fn offsets() -> Vec<u64>;
    /// Name, fields and size, without the type.
    fn layout() -> UniformLayout {
        let fields = Self::FIELDS.iter().copied().zip(Self::offsets()).collect();
        UniformLayout {
            name: Self::NAME,
            fields,
            size: Self::min_size().get(),
        }
    }
    /// The bytes as the shader wants them.
    ///
    /// # Panics
    /// Panics never: a growing buffer takes any struct.
    fn to_bytes(&self) -> Vec<u8> {
        let mut buffer = UniformBuffer::new(Vec::new());
        buffer.write(self).expect("a Vec grows as needed");
        buffer.into_inner()
    }
}

/// A uniform struct of any type: every [`Uniforms`] is one.
pub trait UniformBlock {
    /// Returns name, fields and size.
    fn uniform_layout(&self) -> UniformLayout;
    /// Returns the bytes as the shader wants them.
    fn uniform_bytes(&self) -> Vec<u8>;
}

impl<T: Uniforms> UniformBlock for T {
    fn uniform_layout(&self) -> UniformLayout {
        T::layout()
    }

    fn uniform_bytes(&self) -> Vec<u8> {
        self.to_bytes()
    }
}

/// A uniform struct's layout, to be compared with what the shader compiler makes of its twin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UniformLayout {
    /// The struct's name in WGSL.
    pub name: &'static str,
    /// Each field's name and offset in bytes.
    pub fields: Vec<(&'static str, u64)>,
    /// Bytes in all.
    pub size: u64,
}

/// Declares a struct that is [`Uniforms`](crate::Uniforms): field names and offsets come with it.
/// The WGSL twin has the same name.
#[macro_export]
macro_rules! uniforms {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* pub $field:ident: $t:ty,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, encase::ShaderType)]
        pub struct $name { $($(#[$field_meta])* pub $field: $t,)* }
        impl $crate::Uniforms for $name {
            const NAME: &'static str = stringify!($name);
            const FIELDS: &'static [&'static str] = &[$(stringify!($field)),*];
            fn offsets() -> Vec<u64> {
                (0..Self::FIELDS.len()).map(|i| <Self as encase::ShaderType>::METADATA.offset(i)).collect()
            }
        }
    };
}
