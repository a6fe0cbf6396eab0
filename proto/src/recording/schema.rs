//! One declaration gives a message its Rust type, its protobuf encoding and its embedded schema.

use foxglove::prost_types::field_descriptor_proto::{Label, Type};
use foxglove::prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto,
    FileDescriptorProto, FileDescriptorSet, OneofDescriptorProto,
};
use prost::Message;

/// The protobuf package of every message of ours.
pub const PACKAGE: &str = "cullet";

/// A message that is recorded: it knows its name and can be read back.
pub trait Recorded: Message + Default + Sized {
    /// Full protobuf name, such as `cullet.Body`.
    const NAME: &'static str;
    /// The protobuf bytes: equal messages give equal bytes.
    fn to_bytes(&self) -> Vec<u8> {
        self.encode_to_vec()
    }
    /// Reads a message back.
    ///
    /// # Errors
    /// Bytes that are not such a message.
    fn from_bytes(bytes: &[u8]) -> Result<Self, prost::DecodeError> {
        Self::decode(bytes)
    }
}

/// The lines of a doc comment.
pub(super) type Comment = &'static [&'static str];

/// A message or an enumeration as it is declared: its descriptor, and what its comments say.
pub(super) struct Declaration<D> {
    pub(super) descriptor: D,
    pub(super) comment: Comment,
    /// Of each field or value, in the order of the descriptor.
    pub(super) parts: Vec<Comment>,
}

/// Declares one message. A field reads `tag [prost kind] name: Type`; the descriptor is made of
/// the same words, so type, encoding and schema cannot disagree.
macro_rules! message {
    ($(#[doc = $doc:literal])* $(#[derive($($also:ident),*)])? $name:ident {
        $($(#[doc = $field_doc:literal])*
        $tag:literal [$($kind:tt)*] $field:ident: $ty:ty,)*
    }) => {
        $(#[doc = $doc])*
        #[derive(Clone, PartialEq, prost::Message)]
        $(#[derive($($also),*)])?
        pub struct $name {
            $($(#[doc = $field_doc])* #[prost($($kind)*, tag = $tag)] pub $field: $ty,)*
        }
        impl $crate::recording::schema::Recorded for $name {
            const NAME: &'static str = concat!("cullet.", stringify!($name));
        }
        impl $name {
            fn declaration() -> $crate::recording::schema::MessageDeclaration {
                $crate::recording::schema::Declaration {
                    descriptor: $crate::recording::schema::message_descriptor(stringify!($name), &[
                        $(($tag, stringify!($field), stringify!($($kind)*), stringify!($ty)),)*
                    ]),
                    comment: &[$($doc),*],
                    parts: vec![$(&[$($field_doc),*]),*],
                }
            }
        }
    };
}
pub(super) use message;

/// Declares one enumeration, likewise.
macro_rules! enumeration {
    ($(#[doc = $doc:literal])* $name:ident {
        $($(#[doc = $value_doc:literal])* $variant:ident = $value:literal,)*
    }) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, prost::Enumeration)]
        #[repr(i32)]
        pub enum $name {
            $($(#[doc = $value_doc])* $variant = $value,)*
        }
        impl $name {
            fn declaration() -> $crate::recording::schema::EnumDeclaration {
                $crate::recording::schema::Declaration {
                    descriptor: $crate::recording::schema::enum_descriptor(stringify!($name), &[
                        $((stringify!($variant), $value),)*
                    ]),
                    comment: &[$($doc),*],
                    parts: vec![$(&[$($value_doc),*]),*],
                }
            }
        }
    };
}
pub(super) use enumeration;

/// A message.
pub(super) type MessageDeclaration = Declaration<DescriptorProto>;
/// An enumeration.
pub(super) type EnumDeclaration = Declaration<EnumDescriptorProto>;

/// A field as [`message!`] writes it: tag, name, prost's words for its kind, Rust type.
pub(super) type MessageField = (&'static str, &'static str, &'static str, &'static str);

pub(super) fn message_descriptor(name: &str, fields: &[MessageField]) -> DescriptorProto {
    let mut message = DescriptorProto { name: Some(name.to_owned()), ..Default::default() };
    for field in fields {
        let field = field_descriptor(field, &mut message.oneof_decl);
        message.field.push(field);
    }
    message
}

fn field_descriptor(
    &(tag, name, kind, rust): &MessageField,
    oneofs: &mut Vec<OneofDescriptorProto>,
) -> FieldDescriptorProto {
    let words: Vec<&str> = kind.split(',').map(str::trim).collect();
    let (base, of) = match words[0].split_once('=') {
        Some((base, of)) => (base.trim(), of.trim().trim_matches('"')),
        None => (words[0], inner_type(rust)),
    };
    let r#type = field_type(base);
    let named = matches!(r#type, Type::Message | Type::Enum);
    let repeated = words.contains(&"repeated");
    let mut field = FieldDescriptorProto {
        name: Some(name.to_owned()),
        number: tag.trim_matches('"').parse().ok(),
        label: Some(if repeated { Label::Repeated } else { Label::Optional } as i32),
        r#type: Some(r#type as i32),
        type_name: named.then(|| format!(".{PACKAGE}.{of}")),
        ..Default::default()
    };
    if words.contains(&"optional") && r#type != Type::Message {
        // proto3 keeps the presence of a scalar in a oneof of its own.
        field.proto3_optional = Some(true);
        field.oneof_index = i32::try_from(oneofs.len()).ok();
        oneofs.push(OneofDescriptorProto { name: Some(format!("_{name}")), options: None });
    }
    field
}

/// `Vec<Hit>` and `Option<Hit>` speak of `Hit`.
fn inner_type(rust: &'static str) -> &'static str {
    rust.split_once('<').map_or(rust, |(_, rest)| rest.trim_end_matches('>').trim())
}

fn field_type(kind: &str) -> Type {
    match kind {
        "double" => Type::Double,
        "float" => Type::Float,
        "uint64" => Type::Uint64,
        "uint32" => Type::Uint32,
        "bool" => Type::Bool,
        "string" => Type::String,
        "enumeration" => Type::Enum,
        "message" => Type::Message,
        "bytes" => Type::Bytes,
        other => unreachable!("the messages of this crate have no kind {other}"),
    }
}

pub(super) fn enum_descriptor(name: &str, values: &[(&str, i32)]) -> EnumDescriptorProto {
    let value = |&(variant, number): &(&str, i32)| EnumValueDescriptorProto {
        // Values of all enumerations of a package share one name space.
        name: Some(format!("{}_{}", name.to_uppercase(), screaming(variant))),
        number: Some(number),
        options: None,
    };
    EnumDescriptorProto {
        name: Some(name.to_owned()),
        value: values.iter().map(value).collect(),
        ..Default::default()
    }
}

/// `JobOpened` becomes `JOB_OPENED`.
fn screaming(variant: &str) -> String {
    let mut out = String::new();
    for (i, c) in variant.chars().enumerate() {
        if i > 0 && c.is_uppercase() {
            out.push('_');
        }
        out.extend(c.to_uppercase());
    }
    out
}

/// All that a recording may hold of ours.
pub(super) struct Declarations {
    pub(super) messages: Vec<MessageDeclaration>,
    pub(super) enums: Vec<EnumDeclaration>,
}

impl Declarations {
    /// A `FileDescriptorSet` of one file, as MCAP wants protobuf schemas.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        FileDescriptorSet { file: vec![self.file()] }.encode_to_vec()
    }

    /// The same with a second file, of messages that name those of the first.
    pub(super) fn to_bytes_with(&self, name: &str, more: &[MessageDeclaration]) -> Vec<u8> {
        let first = self.file();
        let second = FileDescriptorProto {
            name: Some(name.to_owned()),
            dependency: vec![first.name().to_owned()],
            message_type: more.iter().map(|it| it.descriptor.clone()).collect(),
            package: first.package.clone(),
            syntax: first.syntax.clone(),
            ..Default::default()
        };
        FileDescriptorSet { file: vec![first, second] }.encode_to_vec()
    }

    fn file(&self) -> FileDescriptorProto {
        FileDescriptorProto {
            name: Some("cullet/recording.proto".to_owned()),
            package: Some(PACKAGE.to_owned()),
            syntax: Some("proto3".to_owned()),
            message_type: self.messages.iter().map(|it| it.descriptor.clone()).collect(),
            enum_type: self.enums.iter().map(|it| it.descriptor.clone()).collect(),
            ..Default::default()
        }
    }
}
