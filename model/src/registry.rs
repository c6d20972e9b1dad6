//! Lists of named things: an enum whose every variant is one row.

/// An enum of named things.
pub trait Listed: Copy + Send + Sync + 'static {
    /// All of them, in the order of lists and figures.
    const ALL: &'static [Self];

    /// Name on the command line and in files.
    fn name(self) -> &'static str;

    /// What it is, in a sentence.
    fn help(self) -> &'static str;
}

/// Declares the enum `$id` with a variant for each row, in the order of every list, help text and figure.
///
/// A row is a constant of type `$row` with the fields `name` (command line, files), `label` (page) and `help` (command line). The enum is
/// [`Listed`], and reads and writes as its name. Adding a row takes its own file and a line here.
#[macro_export]
macro_rules! registry {
    ($(#[$doc:meta])* $id:ident: $row:ty { $($(#[$about:meta])* $variant:ident => $value:expr),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $id { $($(#[$about])* $variant),+ }

        impl $id {
            /// All of them, in the order of lists and figures.
            pub const ALL: &[$id] = &[$($id::$variant),+];

            fn row(self) -> &'static $row {
                match self { $($id::$variant => &$value),+ }
            }

            /// Name on the command line and in files.
            pub fn name(self) -> &'static str {
                self.row().name
            }

            /// Name on the page.
            pub fn label(self) -> &'static str {
                self.row().label
            }

            /// What it is, in a sentence.
            pub fn help(self) -> &'static str {
                self.row().help
            }
        }

        impl std::fmt::Display for $id {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl $crate::registry::Listed for $id {
            const ALL: &'static [$id] = $id::ALL;

            fn name(self) -> &'static str {
                $id::name(self)
            }

            fn help(self) -> &'static str {
                $id::help(self)
            }
        }

        impl serde::Serialize for $id {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> serde::Deserialize<'de> for $id {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<$id, D::Error> {
                let name = <String as serde::Deserialize>::deserialize(deserializer)?;
                let found = $id::ALL.iter().copied().find(|id| id.name() == name);
                found.ok_or_else(|| serde::de::Error::custom(format!("no {} is called `{name}`", stringify!($id))))
            }
        }
    };
}
