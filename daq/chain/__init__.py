"""From a physical signal to blocks of codes: transducers, conditioning, front end, trigger, clock."""
