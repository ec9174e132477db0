"""Who starts what: pacemaker, the sequence of the layers, the mechanoreceptor reflex."""
