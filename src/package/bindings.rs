//! Rust text for binding a variant: uniform blocks as structures whose layout the Rust compiler checks, bindings and
//! tables as plain data. The text needs only `core`, and can stand in a module or an `include!`.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::quote;

use crate::error::{Error, Result};
use crate::package::manifest::{Binding, TableEntry, UniformBlock, VariantManifest};
use crate::shader::template::GENERATED;
use crate::tables::{SAMPLER_NAME, Table};

/// Name of the file beside a variant's manifest.
pub const FILE: &str = "bindings.rs";

/// The text for a variant. Tables are found by the names of their bindings.
pub fn rust(manifest: &VariantManifest, tables: &[&Table]) -> Result<String> {
    let subject = format!("{} {}", manifest.surface, manifest.variant);
    let fail = |cause: String| Error::new(format!("{subject}: {FILE}"), cause);
    let blocks =
        manifest.uniforms.iter().map(block).collect::<Result<Vec<_>, _>>().map_err(fail)?;
    let places: Vec<TokenStream> = manifest.bindings.iter().map(place).collect();
    let mut names = Vec::new();
    let mut constants = Vec::new();
    for entry in &manifest.tables {
        let shape = tables.iter().find(|table| table.name == entry.binding);
        let binding = manifest.bindings.iter().find(|binding| binding.name == entry.binding);
        let (Some(shape), Some(binding)) = (shape, binding) else {
            return Err(fail(format!("table `{}` has no binding in the manifest", entry.binding)));
        };
        names.push(ident(&format!("{}_TABLE", constant_name(&binding.name))));
        constants.push(table(entry, shape, binding));
    }
    let count = Literal::usize_unsuffixed(names.len());
    let [surface, variant] = [&manifest.surface, &manifest.variant];
    let tokens = quote! {
        /// Name of the surface.
        pub const SURFACE: &str = #surface;
        /// Name of the variant.
        pub const VARIANT: &str = #variant;

        #(#blocks)*

        #(#places)*

        /// A table that the shader reads as a texture, at level 0.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct Table {
            /// Bind group.
            pub group: u32,
            /// Binding.
            pub binding: u32,
            /// Path of the texels, relative to the folder of this file. Little-endian, `[layer][row][column][channel]`.
            pub data: &'static str,
            /// Path of the JSON description of the table, relative to the folder of this file.
            pub description: &'static str,
            /// Size of the texels in bytes.
            pub bytes: usize,
            /// WebGPU's name of the texel format.
            pub format: &'static str,
            /// `2d` or `2d-array`.
            pub dimension: &'static str,
            /// Texels along x.
            pub width: u32,
            /// Texels along y.
            pub height: u32,
            /// Number of array layers; 1 for a plain texture.
            pub layers: u32,
            /// Binding of the sampler that the shader reads it through: linear, clamped to the edge. `None` if the
            /// shader reads single texels.
            pub sampler: Option<u32>,
        }

        #(#constants)*

        /// All tables.
        pub const TABLES: [Table; #count] = [#(#names),*];
    };
    let file = syn::parse2(tokens).map_err(|error| fail(error.to_string()))?;
    Ok(format!("// {GENERATED}\n{}", spaced(&prettyplease::unparse(&file))))
}

/// A blank line above every item with a comment.
fn spaced(text: &str) -> String {
    let mut out = String::new();
    let mut inside = false;
    for line in text.lines() {
        let comment = line.starts_with("///");
        if comment && !inside {
            out.push('\n');
        }
        inside = comment;
        out += line;
        out.push('\n');
    }
    out
}

/// A structure with the layout of a uniform block, and the assertions that prove it.
fn block(block: &UniformBlock) -> Result<TokenStream, String> {
    let name = ident(&block.structure);
    let about = format!(" Uniform block `{}`.", block.name);
    let size = Literal::u32_unsuffixed(block.size);
    let bytes = ident(&format!("{}_BYTES", constant_name(&block.name)));
    let about_bytes = format!(" Bytes of uniform block `{}`.", block.name);
    let mut fields = Vec::new();
    let mut checks = vec![quote! {
        #[doc = #about_bytes]
        pub const #bytes: usize = core::mem::size_of::<#name>();
        const _: () = assert!(#bytes == #size);
    }];
    for member in &block.members {
        let field = ident(&member.name);
        let ty = match member.ty {
            "vec4f" => quote! { [f32; 4] },
            "vec4i" => quote! { [i32; 4] },
            "vec4u" => quote! { [u32; 4] },
            "mat4x4f" => quote! { [[f32; 4]; 4] },
            other => {
                return Err(format!(
                    "`{}` has type {other}, which has no Rust equivalent",
                    member.name
                ));
            }
        };
        let about =
            format!(" {}", if member.meaning.is_empty() { member.ty } else { member.meaning });
        let offset = Literal::u32_unsuffixed(member.offset);
        fields.push(quote! { #[doc = #about] pub #field: #ty });
        checks.push(
            quote! { const _: () = assert!(core::mem::offset_of!(#name, #field) == #offset); },
        );
    }
    Ok(quote! {
        #[doc = #about]
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct #name { #(#fields),* }
        #(#checks)*
    })
}

/// Group and binding of a resource.
fn place(binding: &Binding) -> TokenStream {
    let constant = constant_name(&binding.name);
    let parts = [("GROUP", "Bind group", binding.group), ("BINDING", "Binding", binding.binding)];
    let parts = parts.map(|(suffix, what, number)| {
        let name = ident(&format!("{constant}_{suffix}"));
        let about = format!(" {what} of {} `{}`.", binding.kind, binding.name);
        let number = Literal::u32_unsuffixed(number);
        quote! { #[doc = #about] pub const #name: u32 = #number; }
    });
    quote! { #(#parts)* }
}

fn table(entry: &TableEntry, shape: &Table, binding: &Binding) -> TokenStream {
    let constant = constant_name(&binding.name);
    let about = format!(" Table `{}`.", binding.name);
    let name = ident(&format!("{constant}_TABLE"));
    let [group, place] = ["GROUP", "BINDING"].map(|suffix| ident(&format!("{constant}_{suffix}")));
    let TableEntry { data, description, .. } = entry;
    let format = shape.format.name();
    let dimension = binding.dimension.unwrap_or_default();
    let bytes = Literal::usize_unsuffixed(shape.byte_count());
    let sampler = match shape.filtered {
        true => {
            let place = ident(&format!("{}_BINDING", constant_name(SAMPLER_NAME)));
            quote! { Some(#place) }
        }
        false => quote! { None },
    };
    let [width, height, layers] =
        [shape.width, shape.height, shape.layers.max(1)].map(Literal::usize_unsuffixed);
    quote! {
        #[doc = #about]
        pub const #name: Table = Table {
            group: #group,
            binding: #place,
            data: #data,
            description: #description,
            bytes: #bytes,
            format: #format,
            dimension: #dimension,
            width: #width,
            height: #height,
            layers: #layers,
            sampler: #sampler,
        };
    }
}

fn constant_name(name: &str) -> String {
    name.to_ascii_uppercase()
}

/// WGSL names are valid in Rust, except keywords.
fn ident(name: &str) -> Ident {
    match syn::parse_str::<Ident>(name) {
        Ok(ident) => ident,
        Err(_) => Ident::new(&format!("{name}_"), Span::call_site()),
    }
}
