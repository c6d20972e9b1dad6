//! The contacts of a command line, at nodes and at positions.

use super::parse::{AskedContact, AskedDirection, contact_at_node, contact_at_position};
use super::{Failure, bad_input};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use finray_model::scene::TouchedDescription;
use finray_model::sensing::{ContactQuestion, Direction, Lean, Normal};

const AT_NODES: &str = "contact";
const AT_POSITIONS: &str = "contact-at";

/// `--contact` and `--contact-at` in the order in which they are given, which clap's derive keeps for each alone.
pub struct Contacts(Vec<AskedContact>);

impl Contacts {
    /// The contacts with the friction that is known of them, and the object that they touch.
    ///
    /// # Errors
    /// [`Failure::BadInput`] where a direction is that of friction or of an object and none is known.
    pub fn with(
        &self,
        friction: Option<Lean>,
        object: Option<&TouchedDescription>,
    ) -> Result<Vec<ContactQuestion>, Failure> {
        let question = |asked: &AskedContact| {
            let direction = match asked.direction {
                AskedDirection::Itself(direction) => direction,
                AskedDirection::Friction => Direction::Leaning(friction.ok_or_else(|| {
                    bad_input(
                        "a direction is `friction`: expected friction or friction_range in the scene's table contact",
                    )
                })?),
                AskedDirection::Object => {
                    let object = object.ok_or_else(|| {
                        bad_input("a direction is `object`: expected a table contact.object in the scene")
                    })?;
                    // Of an object that may be anywhere nothing is known but that the plate runs along it.
                    let from = match object.place {
                        Some(_) => Normal::Object,
                        None => Normal::Deformed { over_mm: 0.0 },
                    };
                    Direction::Leaning(Lean { from, ..friction.unwrap_or(Lean::NONE) })
                }
            };
            Ok(ContactQuestion { position: asked.position, direction })
        };
        self.0.iter().map(question).collect()
    }
}

impl Args for Contacts {
    fn augment_args(command: Command) -> Command {
        let list = |name| Arg::new(name).long(name).num_args(1..).action(ArgAction::Append);
        command
            .arg(
                list(AT_NODES)
                    .value_name("NODE[@ANGLE_DEG|normal|friction|object|auto]")
                    .value_parser(contact_at_node)
                    .help("Contact at a node of the front plate, tip included"),
            )
            .arg(
                list(AT_POSITIONS)
                    .value_name("S_MM|auto[@ANGLE_DEG|normal|friction|object|auto]")
                    .value_parser(contact_at_position)
                    .help("Contact at a position along the front plate, mm from its base, or at an unknown one"),
            )
    }

    fn augment_args_for_update(command: Command) -> Command {
        Contacts::augment_args(command)
    }
}

impl FromArgMatches for Contacts {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Contacts, clap::Error> {
        let positions_and_values = |name| {
            let positions = matches.indices_of(name).into_iter().flatten();
            positions.zip(matches.get_many::<AskedContact>(name).into_iter().flatten().copied())
        };
        let mut contacts: Vec<_> = positions_and_values(AT_NODES).chain(positions_and_values(AT_POSITIONS)).collect();
        contacts.sort_by_key(|(position, _)| *position);
        Ok(Contacts(contacts.into_iter().map(|(_, contact)| contact).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Contacts::from_arg_matches(matches)?;
        Ok(())
    }
}
