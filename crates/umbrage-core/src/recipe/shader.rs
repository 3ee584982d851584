//! WGSL modules and their uniforms.

use encase::{ShaderType, UniformBuffer, internal::WriteInto};

/// A named piece of WGSL. Shaders are concatenated lists of modules. Kernels share modules, so
/// there are no copies to keep in sync.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Module {
    /// Name for error messages; the stem of its file.
    pub name: &'static str,
    /// The WGSL.
    pub text: &'static str,
}

/// Declares the [`Module`](crate::Module) of the WGSL file with this stem in the Rust file's
/// folder, `module!("pcf")`, or of another file, `module!("soft_holes", "holes.wgsl")`.
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

/// Concatenates the modules' texts, each below a line with its file's name.
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

/// A struct written by Rust and read by WGSL, with the layout of `encase`. Declare it with
/// [`uniforms!`](crate::uniforms).
pub trait Uniforms: ShaderType + WriteInto {
    /// Name of the struct in WGSL.
    const NAME: &'static str;
    /// Names of the fields, in order.
    const FIELDS: &'static [&'static str];
    /// Returns the offsets of the fields in bytes, in order.
    fn offsets() -> Vec<u64>;
    /// Returns name, fields and size, without the type.
    fn layout() -> UniformLayout {
        let fields = Self::FIELDS.iter().copied().zip(Self::offsets()).collect();
        UniformLayout {
            name: Self::NAME,
            fields,
            size: Self::min_size().get(),
        }
    }
    /// Returns the bytes in the shader's layout.
    ///
    /// # Panics
    /// Never panics: a growing buffer accepts any struct.
    fn to_bytes(&self) -> Vec<u8> {
        let mut buffer = UniformBuffer::new(Vec::new());
        buffer.write(self).expect("a Vec grows as needed");
        buffer.into_inner()
    }
}

/// A uniform struct of any type, implemented by every [`Uniforms`].
pub trait UniformBlock {
    /// Returns name, fields and size.
    fn uniform_layout(&self) -> UniformLayout;
    /// Returns the bytes in the shader's layout.
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

/// Layout of a uniform struct, for comparison with the layout that the shader compiler computes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UniformLayout {
    /// Name of the struct in WGSL.
    pub name: &'static str,
    /// Name and offset in bytes of each field.
    pub fields: Vec<(&'static str, u64)>,
    /// Size in bytes.
    pub size: u64,
}

/// Declares a struct that implements [`Uniforms`](crate::Uniforms), with field names and offsets.
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
