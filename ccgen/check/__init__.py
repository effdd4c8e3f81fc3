"""Whether the joints of one bus go together: their files, and the folders exported of them."""
