"""Many runs: planned or listed, carried out in processes, each kept under one key; and studies made of them."""
