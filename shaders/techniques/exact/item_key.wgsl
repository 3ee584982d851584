// Twin of item_key.rs: the key word of an item.

const FIELD = 6u;
const LAST = 31u;
const KEY_STEPS_LOG2 = 5u;
const KEY_STEPS = 32.0;
const GUARDS = 0x20820820u;
const DEPTH_GUARD = 0x20000000u;
